// What lights a scene besides its surfaces, and what weakens light on its way: sky, sun, lamps without extent, medium.
// Plain values; directions are unit vectors in the world.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "format/geometry.h"
#include "solver/scene/ies.h"

namespace rro {

/// Every channel the mean of the three.
constexpr Vec3 grey(const Vec3& colour) {
    const double mean = (colour.x + colour.y + colour.z) / 3;
    return {mean, mean, mean};
}

/// Light from infinitely far, in every direction. The directions are divided into cells (rows of equal latitude by columns
/// of equal longitude); a cell is chosen by its mean radiance times its solid angle, a direction within it uniformly.
class Sky {
  public:
    /// The same radiance, W/(m^2 sr), in every direction. `ground`: nothing comes from below the horizon.
    static Sky uniform(const Vec3& radiance, bool ground);

    /// CIE standard overcast sky [Moon & Spencer 1942]: L = zenith (1 + 2 sin(altitude)) / 3; below the horizon (without
    /// `ground`) as at the horizon, zenith / 3.
    static Sky cie_overcast(const Vec3& zenith, bool ground);

    /// A picture of [height][width] radiances, latitude by longitude as OpenEXR has it (ImfEnvmap.h): the top row is +y,
    /// the middle column +z, a quarter of the width left of it +x. Each pixel is a piece of sky of constant radiance.
    static Sky image(int width, int height, std::vector<Rgb> pixels, bool ground);

    /// Of light that comes from this direction, W/(m^2 sr).
    Vec3 radiance(const Vec3& from) const;

    /// A direction, chosen.
    struct Sample {
        Vec3 from;           // where the light comes from
        Vec3 radiance;       // W/(m^2 sr)
        double density = 0;  // of this choice, 1/sr
    };
    /// The direction that belongs to a point of the unit square. Not for a dark sky.
    Sample sample(double u, double v) const;
    /// Of sample() for this direction, 1/sr.
    double density(const Vec3& from) const;

    bool dark() const { return !(total_ > 0); }
    bool has_ground() const { return ground_; }
    bool is_grey() const;
    Sky grey() const;  // every channel the mean of the three

    /// Is there a cell much brighter than the mean? Then choosing directions by brightness pays.
    bool is_peaked() const;

  private:
    enum class Kind { Uniform, Overcast, Image };

    std::size_t cell(const Vec3& from) const;
    Vec3 cell_radiance(std::size_t cell, const Vec3& from) const;
    double row_edge(std::size_t row) const;  // sine of the latitude above a row
    double row_solid_angle(std::size_t row) const;
    void build_table();

    Kind kind_ = Kind::Uniform;
    bool ground_ = false;
    Vec3 colour_;                            // radiance, or that of the zenith
    std::size_t rows_ = 1, columns_ = 1;
    std::vector<Rgb> pixels_;                // [rows * columns], of an image
    std::vector<double> cumulative_rows_;    // [rows] W/m^2, summed over channels; ascending
    std::vector<double> cumulative_cells_;   // [rows * columns] radiance summed over channels, ascending within a row
    double total_ = 0;                       // radiance times solid angle, summed over channels
};

/// A disc of uniform radiance, infinitely far.
struct Sun {
    Vec3 direction;          // the way light travels
    Vec3 irradiance;         // W/m^2, on a plane that faces the sun
    double angular_radius = 0;  // radians, below pi / 2; 0: all light is parallel

    /// A part of the disc, chosen.
    struct Sample {
        Vec3 from;        // where the light comes from
        Vec3 irradiance;  // W/m^2 that it stands for, on a plane that faces `from`
    };
    /// The part of the disc that belongs to a point of the unit square. The mean of irradiance x cosine over the square is
    /// exact for planes that see the whole disc.
    Sample sample(double u, double v) const;

    /// Of light that comes from this direction; 0 where the sun has no extent.
    Vec3 radiance(const Vec3& from) const;
};

/// A lamp without extent: the same intensity in all directions, in a cone, or as measured.
struct PointLight {
    std::string name;
    Vec3 position;
    Vec3 direction{0, -1, 0};      // the cone's axis; of a measured lamp, its vertical angle 0
    Vec3 intensity;                // W/sr; of a measured lamp where it is brightest
    double cone_cosine = -1;       // of half the opening angle; no light outside
    std::shared_ptr<const IesDistribution> measured;  // or none
    std::uint32_t group = 0;       // into Scene::light_groups

    /// W/sr in the direction in which light leaves.
    Vec3 intensity_towards(const Vec3& direction) const;
};

/// What fills all space and absorbs.
struct Medium {
    Vec3 absorption;  // 1/m per channel, >= 0

    /// Share of light left after a distance, which may be infinite: exp(-a d), and 1 where a is 0.
    Vec3 transmittance(double distance) const;
};

}  // namespace rro
