// Reads interpolated radiosity anywhere on a surface mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "solver/output/surface_mesh.h"

namespace rro {

/// Finds the triangle about a point of a face. Keeps a reference to the mesh. Safe to share between threads.
class SurfaceSampler {
  public:
    explicit SurfaceSampler(const SurfaceMesh& mesh);

    /// Radiosity at barycentric (b1, b2) of face f, in the face's own winding; W/m^2.
    Vec3 radiosity(std::uint32_t face, double b1, double b2) const;

  private:
    /// A square grid over the barycentric unit square of a face that has many triangles.
    struct Grid {
        std::uint32_t size = 0;        // cells along a side; 0: the face is searched without a grid
        std::uint32_t first_cell = 0;  // into cell_begin_
    };
    void add_grid(std::uint32_t face);

    const SurfaceMesh& mesh_;
    std::vector<std::uint32_t> grid_of_face_;   // [F] into grids_; 0 is the empty grid
    std::vector<Grid> grids_;
    std::vector<std::uint32_t> cell_begin_;     // triangles of a cell: listed_[cell_begin_[c]] .. [cell_begin_[c + 1]]
    std::vector<std::uint32_t> listed_;
};

}  // namespace rro
