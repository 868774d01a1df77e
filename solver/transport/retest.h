// After an edit: only pairs that it touches are judged again, in the rounds in which they were judged before, so that the
// links become what refinement of the new scene would make of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solver/transport/node_map.h"
#include "solver/transport/refine.h"

namespace rro {

/// What one link may do in a round of refinement: as in Guide.
struct Shares {
    std::vector<double> of_instance;
    double of_scene = 0;
};

/// What refinement was led by, round after round.
struct Schedule {
    Guide first;                 // of the first round: sources alone
    std::vector<Shares> rounds;  // later ones are led by the light itself
};

/// What an edit touches of a scene, whose nodes are renumbered already.
struct Touched {
    std::vector<std::uint8_t> instance;     // [instances] placed, or moved
    std::vector<std::uint8_t> group;        // [groups] with one of these in it, or with other members
    std::vector<const Instance*> blockers;  // instances that moved, as they stood and as they stand; those placed; those deleted
};

/// before   the scene before, whose instances it points to; those of now are the nodes' scene's
/// renewed  numbers now of the groups before, where they may have others numbers or members; empty: they are the same
Touched touched_by(const SceneChange& change, const Scene& before, const Nodes& nodes, std::span<const std::uint32_t> renewed = {});

/// The elements that pairs end in. The set has a tree, here and below.
UsedElements used_elements(const LinkSet& set, const Nodes& nodes);

/// New numbers for nodes; those that pairs of what is gone end in become kNoNode.
void renumber(LinkSet& set, const std::vector<std::uint32_t>& map);

/// What refinement knew of nodes and instances that stay, under their new numbers; instances placed start as others of their
/// object did.
/// map  [nodes before] their numbers
void carry(Guide& guide, Schedule& schedule, const std::vector<std::uint32_t>& map, const SceneChange& change, const Nodes& nodes);

/// Judges anew the pairs of what is touched and those with a blocker in their shaft.
void retest(LinkSet& set, Nodes& nodes, const LinkBuilder& builder, Schedule& schedule, Guide& guide, const Touched& touched);

}  // namespace rro
