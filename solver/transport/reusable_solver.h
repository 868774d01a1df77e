// A scene that stays solved: what an edit leaves as it is keeps its links and its light.
#pragma once

#include <memory>

#include "solver/transport/transport.h"

namespace rro {

/// Keeps nodes, links and light of the last scene solved. Not thread-safe.
class ReusableSolver {
  public:
    ReusableSolver();
    ~ReusableSolver();
    ReusableSolver(ReusableSolver&&) noexcept;
    ReusableSolver& operator=(ReusableSolver&&) noexcept;

    /// The light of a scene, from that of the last one where the two have enough in common, else from scratch: where
    /// accuracy, effects, sky, sun or medium differ, more than half of the scene has moved (by the squared diagonals of the
    /// instances' boxes), or links are more than one and a half times those of the last solve from scratch. Errors
    /// and estimates are as those of solve_reusable; results do not depend on the number of threads.
    Result<Solution> solve(std::shared_ptr<const Scene> scene, const Plan& plan, const TransportOptions& options,
                           const Progress& progress = {});

    /// What the last solve did to the links.
    const LinkChange& change() const { return change_; }
    /// Did it keep nothing of the solve before?
    bool from_scratch() const { return from_scratch_; }

    /// Of nodes, links and their history.
    std::uint64_t bytes() const;

    struct State;

  private:
    std::unique_ptr<State> state_;
    LinkChange change_;
    bool from_scratch_ = true;
};

}  // namespace rro
