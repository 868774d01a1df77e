// How the links of a scene came about: every pair that refinement has judged, below the pair that it is a part of. A pair's
// shaft holds the shafts of all pairs below it, so this is the index by which an edit finds the links that it touches.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "solver/transport/link.h"

namespace rro {

/// What became of a pair.
enum class PairFate : std::uint8_t { Open, Dropped, Pending, Linked, SplitA, SplitB, Gone };

/// One pair that was judged.
struct PairRecord {
    std::uint32_t a = 0, b = 0, stored = kNotStored;  // as in Pair
    std::uint32_t at = 0;     // Linked: number of the link; split: the first of the pairs below, which lie in a row
    std::uint32_t count = 0;  // of the pairs below
    PairFate fate = PairFate::Open;
    std::uint8_t round = 0;   // of refinement, in which it was decided
    bool looked = false;      // decided by what lies between the two

    bool split() const { return fate == PairFate::SplitA || fate == PairFate::SplitB; }
    Pair pair(std::uint32_t record) const { return {a, b, stored, record}; }
};

/// The records of a link set: the first stands for the scene, the row below it for the pairs that refinement starts from.
/// Records keep their numbers; those that are gone are used again after reuse_gone().
class PairTree {
  public:
    PairTree() { records_.push_back({}); }

    PairRecord& operator[](std::uint32_t r) { return records_[r]; }
    const PairRecord& operator[](std::uint32_t r) const { return records_[r]; }
    std::size_t size() const { return records_.size(); }
    std::vector<PairRecord>& records() { return records_; }

    std::vector<std::uint32_t> record_of_link;  // [links]

    /// Puts a row of open pairs below a record, as `fate` says, and tells the pairs their records. A row that was there
    /// before is the caller's.
    void divide(std::uint32_t record, PairFate fate, std::span<Pair> below);

    /// Makes a record open and everything below it gone; calls unlink(link) for its links, which may renumber others.
    template <class Unlink>
    void clear(std::uint32_t record, const Unlink& unlink);

    /// A row without a record above it, of records that are gone.
    void release(std::uint32_t first, std::uint32_t count);

    /// Lets records that are gone be used again: nothing may refer to them any more.
    void reuse_gone();

    std::uint64_t bytes() const;

  private:
    std::vector<PairRecord> records_;
    std::map<std::uint32_t, std::vector<std::uint32_t>> free_, gone_;  // by length: first records of rows
    std::vector<std::uint32_t> stack_;
};

template <class Unlink>
void PairTree::clear(std::uint32_t record, const Unlink& unlink) {
    stack_.assign(1, record);
    while (!stack_.empty()) {
        const std::uint32_t r = stack_.back();
        stack_.pop_back();
        const PairRecord at = records_[r];
        records_[r].fate = r == record ? PairFate::Open : PairFate::Gone;
        if (at.fate == PairFate::Linked) unlink(at.at);
        if (!at.split()) continue;
        for (std::uint32_t k = 0; k < at.count; ++k) stack_.push_back(at.at + k);
        release(at.at, at.count);
        records_[r].count = 0;
    }
}

}  // namespace rro
