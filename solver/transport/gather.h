// One sweep of light over all links: pull radiosity up, gather over links, push irradiance down to faces and elements.
#pragma once

#include <optional>
#include <vector>

#include "solver/scene/built_in.h"
#include "solver/transport/passage.h"
#include "solver/transport/push_down.h"

namespace rro {

/// Radiosity of every node and the links between them, for C channels.
template <int C>
class LightField {
  public:
    LightField(const Nodes& nodes, const EndAreas& areas);
    LightField(const LightField&) = delete;  // its parts refer to each other
    LightField& operator=(const LightField&) = delete;

    /// What surfaces send, by what they receive and their materials as they are now.
    void relight();

    /// Adds light that surfaces receive: [nodes * C] irradiance times `scale`. What they send is left to relight().
    void add(const std::vector<float>& irradiance, double scale);

    void set_irradiance(const std::vector<float>& irradiance) {
        irradiance_ = irradiance;
        push_all_ = true;
    }

    /// Surfaces of one light group alone emit from now on; kAllGroups: all do.
    static constexpr std::uint32_t kAllGroups = 0xffffffffu;
    void emit_only(std::uint32_t light_group) { light_group_ = light_group; }

    /// The light that nodes of another field receive; what they send follows from the materials here.
    /// node  [nodes there] number here, or kNoNode
    void take_over(const LightField& from, const std::vector<std::uint32_t>& node);

    /// New elements start with their parent's light.
    void grow();

    /// Back to emitted light alone.
    void extinguish();

    /// What leaves receive straight from sky, sun and lamps: a source of every sweep. [nodes]; empty: nothing
    void set_outside(const std::vector<Rgb>& irradiance) {
        outside_ = irradiance;
        push_all_ = true;
    }

    /// The light before any sweep: what is emitted, and the light from outside reflected once.
    void begin();

    /// Prepares the sweeps over these links.
    void set_links(const std::vector<Link>& links);

    /// Keeps from now on, beside the light, what links bring of unit radiosity (bound_rows below), and of both what has
    /// been pushed: for change_links.
    void follow();

    /// The same for links that differ from those before only at these nodes, in any order. What other nodes receive stays.
    void change_links(const std::vector<Link>& links, const std::vector<std::uint32_t>& ends);

    /// Surfaces and clusters whose radiosity has changed by less than this part of the reflected norm as it is now keep
    /// sending what they sent: 0 is exact.
    void leave_unsent(double part);
    /// Area-weighted root mean square over leaf surfaces of what the last sweep left unsent, W/m^2. No more than this may
    /// be missing from the change that it returned.
    double unsent() const { return unsent_; }

    /// For a closed shell (is_closed_shell below): what every leaf receives under unit radiosity all around must be 1. Scales
    /// each leaf's irradiance so from now on, unless it is further off than a factor of two: then it
    /// is hidden in other parts. Call after set_links.
    /// returns  area-weighted root mean square of the defect before
    double close_rows();

    /// No surface receives more than 1 under unit radiosity all around. Where a surface's own links and those of the nodes
    /// above it say more, an object stands so close to it that those above cannot see how it hides the rest (a box on a
    /// floor): from now on their light is scaled down. Call after set_links, before close_rows.
    void bound_rows();

    /// One Jacobi sweep: irradiance from the present radiosity, then radiosity = exitance + reflectance * irradiance.
    /// returns  area-weighted root mean square over leaf surfaces and channels of the change of B
    double sweep();

    /// Adds `times` what the last sweep changed in the irradiance; nothing falls below 0.
    void advance(double times);

    /// Area-weighted root mean square of R = B - M over leaf surfaces and channels.
    double reflected_norm() const;

    /// Fills a guide (fill_guide.h) with the light of sources alone, which begin() starts from.
    void fill_sources(Guide& guide);

    const std::vector<float>& radiosity() const { return radiosity_; }    // [nodes * C]
    const std::vector<float>& irradiance() const { return irradiance_; }  // [nodes * C], surfaces only
    std::uint64_t bytes() const;
    float reflectance(std::uint32_t surface, std::size_t channel) const;
    float transmittance(std::uint32_t surface, std::size_t channel) const;
    float exitance(std::uint32_t surface, std::size_t channel) const;

  private:
    template <class F>
    void for_each_passage(const F& f) {
        f(light_);
        if (unit_) f(*unit_);
    }
    void add_links(const std::vector<Link>& links, const std::vector<std::uint8_t>& wanted);
    void transport(Push what = Push::Light);  // radiosity_ -> irradiance_ of leaves
    double find_unsent() const;
    void reflect_instance(std::uint32_t i);  // leaves' irradiance -> radiosity of all nodes
    void pull_instance(std::uint32_t i);
    void pull_groups();  // after all instances
    bool leaf(std::uint32_t surface) const { return nodes_[surface].child_count == 0; }
    template <class F>
    void for_each_leaf(std::uint32_t i, const F& f) const;

    void transmit(std::uint32_t i);  // adds to radiosity what comes through from the other side
    float sources(std::uint32_t surface, std::size_t channel) const;
    bool lit_from_outside() const { return kOutsideLight && !outside_.empty(); }
    bool transmits(std::uint32_t i) const { return built_in("transmission") && !other_side_[i].empty(); }

    const Nodes& nodes_;
    const EndAreas& areas_;
    HalfLinks<C> links_;
    Passage<C> light_;
    std::optional<Passage<C>> unit_;                 // with unit radiosity everywhere: where edits follow
    PushDown<C> push_down_;
    double unsent_part_ = 0, tolerance_ = 0;         // relative, and in W/m^2
    double unsent_ = 0;                              // W/m^2
    bool push_all_ = true;                           // irradiance_ is not what the last sweep made of it
    std::vector<std::uint8_t> reached_;              // [instances] by the last sweep
    std::uint32_t light_group_ = kAllGroups;         // that emits
    std::vector<float> radiosity_, irradiance_;      // [nodes * C]
    std::vector<Rgb> outside_;                       // [nodes] leaves' irradiance from sky, sun and lamps, or empty
    std::vector<std::vector<std::uint32_t>> other_side_;  // [instances][faces] node of the other side; empty: nothing passes
    std::vector<float> before_;                      // [nodes * C] irradiance of the last sweep
    std::vector<float> row_scale_;                   // [nodes], leaves of closed scenes; else empty
};

/// One closed shell that faces inwards and nothing else: light leaves nowhere. (With other objects inside, refinement
/// follows the light so unevenly that rows under unit radiosity say little about the error under the real one.)
bool is_closed_shell(const Scene& scene);

}  // namespace rro
