#include "compiler/archive_diff_parts.h"
#include "compiler/archive_facts.h"
#include "compiler/diff_words.h"

namespace rro {
namespace {

/// Of the light that leaves faces evenly, the share that meets faces again.
double mean_received(const ObjectData& data) {
    double sum = 0, area = 0;
    for (std::size_t p = 0; p < data.self_received.size(); ++p) {
        sum += static_cast<double>(data.patches[p].area) * static_cast<double>(data.self_received[p]);
        area += static_cast<double>(data.patches[p].area);
    }
    return area > 0 ? sum / area : 0;
}

}  // namespace

void compare_self_links(const ObjectData& a, const ObjectData& b, Changes& out) {
    const auto add = [&](const char* kind, const std::string& what, auto before, auto after) {
        if (before != after) out.push_back({"tables", kind, what, before, after, {}, what + ": " + from_to(before, after)});
    };
    add("self_links", "self links", std::uint64_t{a.self_exchange.size()}, std::uint64_t{b.self_exchange.size()});
    if (a.self_received.empty() || b.self_received.empty()) return;
    add("self_received", "share of light that meets the object again", mean_received(a), mean_received(b));
    add("closure", "error of the sum of patches' light", closure_defect(a).rms, closure_defect(b).rms);
}

}  // namespace rro
