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
    compare_count("tables", "self_links", "self links", a.self_exchange.size(), b.self_exchange.size(), out);
    if (a.self_received.empty() || b.self_received.empty()) return;
    compare_number("tables", "self_received", "share of light that meets the object again", mean_received(a), mean_received(b), out);
    compare_number("tables", "closure", "error of the sum of patches' light", closure_defect(a).rms, closure_defect(b).rms, out);
}

}  // namespace rro
