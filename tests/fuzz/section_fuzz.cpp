// One section: the first byte chooses its kind (of layout::kSections), the rest is its FlatBuffers buffer. What
// verify_table lets pass must be readable through TableView, whatever it is.
#include <string>
#include <vector>

#include "format/verifier.h"
#include "tests/fuzz/reading.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace rro;
    if (size == 0) return 0;
    const layout::SectionSpec& section = layout::kSections[data[0] % layout::kSections.size()];
    // A copy of its own: aligned as sections are, and an overrun meets the sanitizer.
    const auto bytes = std::as_bytes(std::span(data, size)).subspan(1);
    const std::vector<std::byte> buffer(bytes.begin(), bytes.end());
    if (verify_table(buffer, section.table, std::string(section.name)))
        fuzz::read_table(TableView::root(buffer), section.table);
    return 0;
}
