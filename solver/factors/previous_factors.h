// Factors computed earlier, for a scene of which little has changed since: what can be taken from them.
#pragma once

#include <filesystem>

#include "solver/factors/view_factors.h"

namespace rro {

/// A matrix as read back from a JSON file of factors.
struct PreviousFactors : Factors {
    std::filesystem::path path;
};

/// Reads a JSON file that write_factors has written.
///
/// errors   Failed: cannot be read. BadInput: not JSON, another format, or not consistent; a matrix that was closed or
///          written with a threshold: what has been left out or moved cannot be told
Result<PreviousFactors> read_previous_factors(const std::filesystem::path& path);

/// Which pairs of groups are what they were: neither has changed, and nothing that has reaches, or reached, into the hull
/// of both.
class Unchanged {
  public:
    Unchanged() = default;  // nothing is

    /// boxes    [G] of the groups' fronts
    ///
    /// errors   BadInput: `previous` was computed with other options (--by, --sides, --accuracy)
    static Result<Unchanged> between(const PreviousFactors& previous, const FactorTable& now,
                                     const std::vector<Box3>& boxes);

    bool empty() const { return previous_ == nullptr; }
    bool holds(std::uint32_t i, std::uint32_t j) const;
    /// Calls take(factor) for the factors other than 0 of a row that still hold, with the groups' numbers of now.
    void each_in_row(std::uint32_t i, const std::function<void(const Factor&)>& take) const;
    /// The factor from i to j as it was.
    double value(std::uint32_t i, std::uint32_t j) const;

  private:
    const PreviousFactors* previous_ = nullptr;
    std::vector<Box3> boxes_;             // [G]
    std::vector<Box3> changed_;           // of instances that have come, gone, moved or changed: before and after
    std::vector<std::uint32_t> earlier_;  // [G] number of then, or kNoGroup where the group has changed
    std::vector<std::uint32_t> now_;      // [groups of then] number of now, or kNoGroup
};

/// What an instance is, for later.
std::vector<InstanceRecord> record_instances(const Scene& scene, const SurfaceGroups& groups);

}  // namespace rro
