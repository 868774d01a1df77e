// Self links: which clusters of one object exchange light with one another, how much, and what the object itself hides.
// Geometry and own visibility only, so an archive holds them and every instance uses them.
//
// The pairs form a tree. It starts with the whole object against itself and ends in links, or in pairs that cannot see
// one another. Stored is what happens to each pair, in preorder; a pair's clusters follow from the way to it:
//
//   Dark        no point of one can lie in front of any point of the other
//   Link        two numbers: the exchange area if nothing stood between them, and the share of it that the object leaves
//   SplitFirst  (a, b) -> (a's left child, b), (a's right child, b)
//   SplitSecond (a, b) -> (a, b's left child), (a, b's right child)
//   SplitSelf   (a, a) -> (left, left), (left, right), (right, right)
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "format/object_data.h"

namespace rro {

/// As stored; FORMAT.md, "Self links".
enum class PairStep : std::uint8_t { Dark, Link, SplitFirst, SplitSecond, SplitSelf };
inline constexpr std::uint32_t kPairSteps = 5;

/// One pair of the tree. Exchange areas are A_a F_ab = A_b F_ba in m^2, in the archive's frame; of a pair of a cluster
/// with itself A F_aa, light in both ways counted.
struct SelfPair {
    std::uint32_t a = 0, b = 0;  // clusters
    std::uint32_t end = 0;       // number of the pair after this one's subtree; children start at own number + 1
    PairStep step = PairStep::Dark;
    float unoccluded = 0;        // exchange area if nothing stood between, summed over the links below
    float seen = 0;              // what the object's own triangles leave of it
};

/// The pairs of a verified object, in preorder; empty where it has no self links.
std::vector<SelfPair> self_pairs(const ObjectData& object);

/// Why steps and numbers of links are no pair tree of these clusters.
struct SelfPairFault {
    std::size_t step = 0;  // number of the step where it shows
    std::string found, expected;
};

/// Does every step fit its pair, and do steps and links end together? Looks at self_steps alone and at how many links
/// there are; clusters may be unverified.
std::optional<SelfPairFault> check_self_pairs(const ObjectData& object);

}  // namespace rro
