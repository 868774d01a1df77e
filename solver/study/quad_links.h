// Links of hierarchical radiosity: which elements exchange light, how much, and which links are too coarse.
//
// source  P. Hanrahan, D. Salzman, L. Aupperle, "A Rapid Hierarchical Radiosity Algorithm", SIGGRAPH 1991.
#pragma once

#include <cstdint>
#include <vector>

#include "format/result.h"
#include "solver/progress.h"
#include "solver/study/quad_elements.h"

namespace rro {

/// A link carries light both ways: element a receives exchange * B_b watts, and b exchange * B_a.
struct QuadLink {
    std::uint32_t a, b;
    float exchange;  // m^2, visibility included
    float largest;   // m^2, what the oracle takes it for: more than `exchange` where something is partly between or behind
};

/// What decides when a pair of elements is fine enough.
struct QuadOracle {
    double link_power = 0;  // W: a link that may carry more is refined
    double root_power = 0;  // W: two faces that cannot exchange more are not linked yet
    std::uint64_t memory = 0;  // bytes, for links and elements
};

/// Rays per tested pair of elements: half of the 16 that HSA91 took, as all levels of refinement test; and of a pair that
/// carries less than kDimShare of what is allowed, whose noise drowns in that of all the others.
inline constexpr int kRaysPerQuadLink = 8, kRaysPerDimLink = 2;
inline constexpr double kDimShare = 0.125;

/// Adds links round by round, as light becomes known. Deterministic: pairs are judged in parallel, applied in order.
class QuadLinker {
  public:
    QuadLinker(const Scene& scene, QuadElements& elements, const SceneRays& rays);

    /// Bytes that links of all pairs of faces that face each other would take, from a sample of the faces.
    std::uint64_t bytes_of_root_links() const;

    /// Links pairs of faces that have become worth it (HSA's initial links, made lazily), and refines links that carry more
    /// than the oracle allows, by the radiosity of every element (BF refinement: form factor, radiosity, area).
    ///
    /// light    [elements] radiosity, mean over the channels; grows with the elements: parts have their parent's
    /// returns  whether anything changed
    /// errors   Failed: more memory than allowed
    Result<bool> refine(const QuadOracle& oracle, std::vector<float>& light, const Progress& progress);

    const std::vector<QuadLink>& links() const { return links_; }
    std::uint64_t rays() const { return rays_traced_; }
    double link_seconds() const { return link_seconds_; }              // visibility not included
    double visibility_seconds() const { return visibility_seconds_; }

  private:
    struct Pair {
        std::uint32_t a, b;
        bool clear;  // nothing can stand between
    };
    struct Verdict;

    std::vector<Pair> new_root_pairs(const QuadOracle& oracle, const std::vector<float>& light);
    void take_coarse_links(const QuadOracle& oracle, std::vector<float>& light, std::vector<Pair>& pairs);
    void split(const Pair& pair, std::vector<float>& light, std::vector<Pair>& pairs);
    bool can_split(const QuadElement& a, const QuadElement& b) const;
    void weigh(const Pair& pair, double light, double limit, Verdict& verdict) const;
    void look(const Pair& pair, double light, double limit, Verdict& verdict) const;

    const Scene& scene_;
    QuadElements& all_;
    const SceneRays& rays_;
    std::vector<QuadLink> links_;
    std::vector<std::uint64_t> linked_;  // a bit for each pair of faces a < b, in rows of whole words
    std::size_t words_ = 0;              // in a row
    std::uint64_t rays_traced_ = 0;
    double link_seconds_ = 0, visibility_seconds_ = 0;
};

/// Bytes of memory for each link: itself, its two entries by receiver, and its share of the work in progress.
inline constexpr std::uint64_t kBytesPerQuadLink = 48;

}  // namespace rro
