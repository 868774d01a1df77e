#include "solver/factors/previous_factors.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "solver/factors/factors_output.h"
#include "solver/visibility/box_hull.h"

namespace rro {
namespace {

using nlohmann::json;

FactorRow row_of(const json& row) {
    const auto to = row.at("to").get<std::vector<std::uint32_t>>();
    const auto value = row.at("factor").get<std::vector<double>>();
    const auto error = row.at("standard_error").get<std::vector<float>>();
    if (to.size() != value.size() || to.size() != error.size() || !std::is_sorted(to.begin(), to.end()))
        throw std::invalid_argument("lists of a row differ in length or order");
    FactorRow result;
    for (std::size_t k = 0; k < to.size(); ++k) result.push_back({to[k], error[k], value[k]});
    return result;
}

InstanceRecord record_of(const json& instance) {
    InstanceRecord record;
    record.name = instance.at("name");
    record.content = instance.at("content");
    record.to_world = instance.at("to_world").get<std::array<double, 12>>();
    const auto bounds = instance.at("bounds").get<std::array<double, 6>>();
    record.bounds = {{bounds[0], bounds[1], bounds[2]}, {bounds[3], bounds[4], bounds[5]}};
    for (const json& group : instance.at("groups"))
        record.groups.push_back(group.is_null() ? kNoGroup : group.get<std::uint32_t>());
    return record;
}

/// Throws where something is missing or of another type.
PreviousFactors factors_of(const json& file) {
    PreviousFactors f;
    if (file.at("format") != kFactorsFormat) throw std::invalid_argument("another format");
    const auto by = parse_group_by(file.at("by").get<std::string>());
    const auto sides = parse_sides(file.at("sides").get<std::string>());
    if (!by || !sides) throw std::invalid_argument("\"by\" or \"sides\"");
    f.options.by = *by;
    f.options.sides = *sides;
    f.options.accuracy = file.at("accuracy");
    for (const json& group : file.at("groups")) {
        f.names.push_back(group.at("name"));
        f.area.push_back(group.at("area"));
    }
    for (const json& instance : file.at("instances")) f.instances.push_back(record_of(instance));
    for (const InstanceRecord& instance : f.instances)
        for (const std::uint32_t group : instance.groups)
            if (group != kNoGroup && group >= f.names.size()) throw std::invalid_argument("a group that is not there");
    return f;
}

/// The file as JSON but for the rows, which go straight into vectors: as JSON they would take ten times the memory.
json parse_file(std::istream& in, std::vector<FactorRow>& rows) {
    return json::parse(in, [&](int depth, json::parse_event_t event, json& value) {
        if (depth != 2 || event != json::parse_event_t::object_end || !value.contains("from")) return true;
        if (value["from"] != rows.size()) throw std::invalid_argument("rows are not in order");
        rows.push_back(row_of(value));
        return false;
    });
}

bool same_object(const InstanceRecord& a, const InstanceRecord& b) {
    return a.content == b.content && a.to_world == b.to_world;
}

}  // namespace

Result<PreviousFactors> read_previous_factors(const std::filesystem::path& path) {
    std::ifstream in(path);
    if (!in) return failed(path.string(), "cannot be read");
    const auto refuse = [&](const std::string& what) {
        return bad_input(path.string(), what + ", expected a matrix that rro-solve factors --out FILE.json has written");
    };
    try {
        std::vector<FactorRow> rows;
        const json file = parse_file(in, rows);
        for (const char* key : {"threshold", "closed"})
            if (file.contains(key))
                return bad_input(path.string(), std::string("has \"") + key + "\": what was left out or moved cannot be told",
                                 "write the matrix to be reused without --threshold and --close");
        PreviousFactors factors = factors_of(file);
        factors.path = path;
        factors.rows = std::move(rows);
        if (factors.rows.size() != factors.names.size()) return refuse("has not as many rows as groups");
        for (const FactorRow& row : factors.rows)
            if (!row.empty() && row.back().to >= factors.names.size()) return refuse("has a factor to a group that is not there");
        return factors;
    } catch (const json::exception& error) {
        return refuse(error.what());
    } catch (const std::invalid_argument& error) {
        return refuse(error.what());
    }
}

Result<Unchanged> Unchanged::between(const PreviousFactors& previous, const FactorTable& now,
                                     const std::vector<Box3>& boxes) {
    const FactorOptions &then = previous.options, &asked = now.options;
    if (then.by != asked.by || then.sides != asked.sides || then.accuracy != asked.accuracy)
        return bad_input(previous.path.string(), "was computed with other options",
                         "ask for the same --by, --sides and --accuracy");
    Unchanged result;
    result.previous_ = &previous;
    result.boxes_ = boxes;
    std::map<std::string, std::uint32_t> group_of_name;
    for (std::uint32_t g = 0; g < now.names.size(); ++g) group_of_name.emplace(now.names[g], g);
    for (const std::string& name : previous.names) {
        const auto at = group_of_name.find(name);
        result.now_.push_back(at == group_of_name.end() ? kNoGroup : at->second);
    }
    const auto name_of_group = [](const FactorTable& table, std::uint32_t g) {
        return g == kNoGroup ? std::string() : table.names[g];
    };
    const auto same_groups = [&](const InstanceRecord& a, const InstanceRecord& b) {
        return a.groups.size() == b.groups.size() &&
               std::equal(a.groups.begin(), a.groups.end(), b.groups.begin(), [&](std::uint32_t x, std::uint32_t y) {
                   return (x == kNoGroup) == (y == kNoGroup) && name_of_group(previous, x) == name_of_group(now, y);
               });
    };
    const auto change_groups = [&](const FactorTable& table, const InstanceRecord& instance, std::vector<std::uint8_t>& changed) {
        for (const std::uint32_t group : instance.groups)
            if (group != kNoGroup)
                if (const auto at = group_of_name.find(table.names[group]); at != group_of_name.end()) changed[at->second] = 1;
    };
    std::vector<std::uint8_t> changed(now.names.size(), 0);
    std::map<std::string, const InstanceRecord*> earlier;
    for (const InstanceRecord& instance : previous.instances) earlier.emplace(instance.name, &instance);
    for (const InstanceRecord& instance : now.instances) {
        const auto at = earlier.find(instance.name);
        const InstanceRecord* before = at == earlier.end() ? nullptr : at->second;
        const bool same = before && same_object(*before, instance);
        if (!same || !same_groups(*before, instance)) {
            change_groups(now, instance, changed);
            if (before) change_groups(previous, *before, changed);
        }
        if (!same) {
            result.changed_.push_back(instance.bounds);
            if (before) result.changed_.push_back(before->bounds);
        }
        if (before) earlier.erase(at);
    }
    for (const auto& [name, instance] : earlier) {  // those that have gone
        change_groups(previous, *instance, changed);
        result.changed_.push_back(instance->bounds);
    }
    result.earlier_.assign(now.names.size(), kNoGroup);
    for (std::uint32_t g = 0; g < result.now_.size(); ++g)
        if (const std::uint32_t today = result.now_[g]; today != kNoGroup) {
            if (changed[today])
                result.now_[g] = kNoGroup;
            else
                result.earlier_[today] = g;
        }
    return result;
}

bool Unchanged::holds(std::uint32_t i, std::uint32_t j) const {
    if (empty() || earlier_[i] == kNoGroup || earlier_[j] == kNoGroup) return false;
    if (changed_.empty()) return true;
    const BoxHull hull(boxes_[i], boxes_[j]);
    return std::all_of(changed_.begin(), changed_.end(), [&](const Box3& box) { return hull.misses(box); });
}

void Unchanged::each_in_row(std::uint32_t i, const std::function<void(const Factor&)>& take) const {
    if (empty() || earlier_[i] == kNoGroup) return;
    for (Factor factor : previous_->rows[earlier_[i]]) {
        factor.to = now_[factor.to];
        if (factor.to != kNoGroup && holds(i, factor.to)) take(factor);
    }
}

double Unchanged::value(std::uint32_t i, std::uint32_t j) const {
    const FactorRow& row = previous_->rows[earlier_[i]];
    const auto at = std::lower_bound(row.begin(), row.end(), earlier_[j],
                                     [](const Factor& factor, std::uint32_t to) { return factor.to < to; });
    return at != row.end() && at->to == earlier_[j] ? at->value : 0;
}

std::vector<InstanceRecord> record_instances(const Scene& scene, const SurfaceGroups& groups) {
    std::map<const Object*, std::string> contents;
    std::vector<InstanceRecord> records;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        std::string& content = contents[instance.object];
        if (content.empty()) content = instance.object->archive.content_sha256();
        InstanceRecord record{instance.name, content, {}, instance.bounds, groups.of_material[i]};
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column)
                record.to_world[static_cast<std::size_t>(4 * row + column)] =
                    column < 3 ? instance.to_world.linear(row, column) : instance.to_world.translation[row];
        records.push_back(std::move(record));
    }
    return records;
}

}  // namespace rro
