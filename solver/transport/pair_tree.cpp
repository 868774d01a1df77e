#include "solver/transport/pair_tree.h"

namespace rro {

void PairTree::divide(std::uint32_t record, PairFate fate, std::span<Pair> below) {
    const auto count = static_cast<std::uint32_t>(below.size());
    std::uint32_t first = 0;
    if (count > 0) {
        std::vector<std::uint32_t>& rows = free_[count];
        if (rows.empty()) {
            first = static_cast<std::uint32_t>(records_.size());
            records_.resize(records_.size() + count);
        } else {
            first = rows.back();
            rows.pop_back();
        }
    }
    for (std::uint32_t k = 0; k < count; ++k) {
        Pair& pair = below[k];
        pair.record = first + k;
        records_[pair.record] = {pair.a, pair.b, pair.stored};
    }
    PairRecord& r = records_[record];
    r.fate = fate;
    r.at = first;
    r.count = count;
}

void PairTree::release(std::uint32_t first, std::uint32_t count) {
    if (count > 0) gone_[count].push_back(first);
}

void PairTree::reuse_gone() {
    for (auto& [count, rows] : gone_) {
        std::vector<std::uint32_t>& to = free_[count];
        to.insert(to.end(), rows.begin(), rows.end());
    }
    gone_.clear();
}

std::uint64_t PairTree::bytes() const {
    return records_.size() * sizeof(PairRecord) + record_of_link.size() * sizeof(std::uint32_t);
}

}  // namespace rro
