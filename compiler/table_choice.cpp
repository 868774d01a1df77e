#include "compiler/table_choice.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace rro {
namespace {

struct NamedTable {
    std::string_view name;
    bool TableChoice::*chosen;
};
constexpr std::array kTables{
    NamedTable{"area", &TableChoice::area},     NamedTable{"visibility", &TableChoice::visibility},
    NamedTable{"errors", &TableChoice::errors}, NamedTable{"hit", &TableChoice::hit},
    NamedTable{"atlas", &TableChoice::atlas},   NamedTable{"selflinks", &TableChoice::selflinks},
};

TableChoice no_tables() {
    TableChoice none;
    for (const NamedTable& table : kTables) none.*table.chosen = false;
    return none;
}

Error usage(const std::string& text, const std::string& message, std::string hint = {}) {
    return {ErrorKind::Usage, "", "--tables " + text + ": " + message, std::move(hint)};
}

}  // namespace

Result<TableChoice> parse_tables(const std::string& text) {
    if (text == "default") return TableChoice{};
    if (text == "all") {
        TableChoice all;
        all.every_node = true;
        return all;
    }
    TableChoice tables = no_tables();
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find(',', at), text.size());
        const std::string name = text.substr(at, end - at);
        const auto known =
            std::find_if(kTables.begin(), kTables.end(), [&](const NamedTable& table) { return table.name == name; });
        if (known == kTables.end())
            return usage(text, (name.empty() ? "a name is missing" : "there is no table " + name) +
                                   ", expected default, all, or some of area, visibility, errors, hit, atlas, "
                                   "selflinks with commas between them");
        tables.*known->chosen = true;
        at = end + 1;
    }
    if (tables.errors && !(tables.area && tables.visibility))
        return usage(text, "errors are those of area and visibility, which must be in the list too");
    return tables;
}

std::string tables_text(const TableChoice& tables) {
    if (tables == TableChoice{}) return "default";
    if (tables.every_node) return "all";
    std::string text;
    for (const NamedTable& table : kTables)
        if (tables.*table.chosen) text += (text.empty() ? "" : ",") + std::string(table.name);
    return text;
}

}  // namespace rro
