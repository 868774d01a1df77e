#include "solver/transport/scene_change.h"

#include <algorithm>
#include <string_view>
#include <unordered_map>

namespace rro {

bool SceneChange::places() const {
    return !deleted.empty() || std::find(moved.begin(), moved.end(), 1) != moved.end();
}

SceneChange scene_change(const Scene& before, const Scene& after) {
    std::unordered_map<std::string_view, std::uint32_t> named;
    for (std::uint32_t i = 0; i < before.instances.size(); ++i) named.emplace(before.instances[i].name, i);
    SceneChange change;
    std::vector<std::uint8_t> stays(before.instances.size(), 0);
    for (const Instance& now : after.instances) {
        const auto found = named.find(now.name);
        const bool known = found != named.end() && before.instances[found->second].object == now.object;
        change.before.push_back(known ? found->second : SceneChange::kPlaced);
        change.moved.push_back(1);
        if (!known) continue;
        const Instance& then = before.instances[found->second];
        stays[found->second] = 1;
        change.moved.back() = then.to_world == now.to_world ? 0 : 1;
        change.exitance = change.exitance || then.exitance != now.exitance;
        change.reflectance = change.reflectance || then.reflectance != now.reflectance;
        change.transmittance = change.transmittance || then.transmittance != now.transmittance;
    }
    for (std::uint32_t i = 0; i < stays.size(); ++i)
        if (!stays[i]) change.deleted.push_back(i);
    const auto same_intensity = [](const PointLight& a, const PointLight& b) { return a.intensity == b.intensity; };
    change.lights = before.manifest.lights != after.manifest.lights ||
                    !std::equal(before.lights.begin(), before.lights.end(), after.lights.begin(), after.lights.end(), same_intensity);
    const auto absorption = [](const Scene& s) { return s.medium ? s.medium->absorption : Vec3{}; };
    change.surroundings = before.manifest.sky != after.manifest.sky || before.manifest.sun != after.manifest.sun ||
                          before.sky.has_value() != after.sky.has_value() || before.sun.has_value() != after.sun.has_value() ||
                          absorption(before) != absorption(after);
    return change;
}

bool same_shapes(const Scene& before, const Scene& after, const SceneChange& change) {
    constexpr double kSame = 1e-9;  // relative, of products of axes: rounding of the manifest's numbers
    for (std::uint32_t i = 0; i < change.before.size(); ++i) {
        if (change.before[i] != i) return false;
        if (!change.moved[i]) continue;
        const Mat3 &a = before.instances[i].to_world.linear, &b = after.instances[i].to_world.linear;
        const Mat3 x = a.transposed() * a, y = b.transposed() * b;
        for (std::size_t r = 0; r < 3; ++r)
            if (length(x.rows[r] - y.rows[r]) > kSame * length(x.rows[r])) return false;
        if ((a.determinant() < 0) != (b.determinant() < 0)) return false;
    }
    return change.deleted.empty();
}

}  // namespace rro
