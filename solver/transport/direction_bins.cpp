#include "solver/transport/direction_bins.h"

#include <algorithm>
#include <cassert>
#include <numbers>
#include <utility>

#include "format/parallel.h"
#include "solver/transport/channels.h"

namespace rro {

namespace {

// A translated source cannot come nearer than this share of its distance from the bins' own centre: the five-times rule
// keeps true sources further away, mean positions of several sources may not.
constexpr double kNearestTranslation = 1.0 / 3;

// Largest ratio of a counted area to the exact one that is taken for noise of the count.
constexpr double kMostShare = 1.25;

// Errors of tables: at least this much, since interpolated radiosity varies, too; and where none was measured.
constexpr double kLeastError = 0.02, kUnmeasured = 0.1;

constexpr std::size_t kLanes = 8;  // partial sums per loop: one AVX register of floats

// Patches of at least so many faces receive one vector for all of them.
constexpr std::uint32_t kFewFaces = 3;

float total(const float (&lanes)[kLanes]) {
    float sum = 0;
    for (const float x : lanes) sum += x;
    return sum;
}

}  // namespace

Arrival translated(const Vec3& sum, double strength, double over_distance, const Vec3& offset) {
    const Vec3 u = normalised(sum);
    if (!(over_distance > 0)) return {u};
    const double d = strength / over_distance;
    const Vec3 e = u * d - offset;
    const double v = std::max(length(e), kNearestTranslation * d);
    return {normalised(e), 1 / v, static_cast<float>(d * d / (v * v))};
}

ObjectTables::ObjectTables(const ObjectData& data, const DirectionGrid& grid)
    : stride((grid.size() + kLanes - 1) / kLanes * kLanes) {
    const std::size_t d_count = grid.size(), p_count = data.patches.size();
    cosine_area.assign(p_count * stride, 0);
    visibility.assign(p_count * stride, 0);
    face_area_sum.assign(data.faces.size() + 1, 0);
    std::vector<Vec3> area_vectors(data.faces.size());
    for (std::size_t f = 0; f < data.faces.size(); ++f) {
        area_vectors[f] = area_vector(data.corners(data.faces[f]));
        face_area_sum[f + 1] = face_area_sum[f] + length(area_vectors[f]);
    }
    parallel_for(p_count, 64, [&](std::size_t p) {
        const Patch& patch = data.patches[p];
        for (std::size_t k = 0; k < d_count; ++k) {
            double sum = 0;
            for (std::uint32_t f = 0; f < patch.face_count; ++f)
                sum += std::max(0.0, dot(area_vectors[patch.first_face + f], grid.direction(static_cast<std::uint32_t>(k))));
            cosine_area[p * stride + k] = static_cast<float>(sum);
            visibility[p * stride + k] = static_cast<float>(data.visibility[p * d_count + k]) / 255.0f;
        }
    });
    mixed.assign(data.clusters.size(), 0);
    if (data.meta.closed) {
        std::vector<std::uint32_t> seen(p_count + 1, 0);
        for (std::size_t p = 0; p < p_count; ++p) {
            const auto row = data.visibility.subspan(p * d_count, d_count);
            seen[p + 1] = seen[p] + (std::any_of(row.begin(), row.end(), [](std::uint8_t v) { return v > 0; }) ? 1 : 0);
        }
        for (std::size_t c = 0; c < mixed.size(); ++c) {
            const Cluster& cluster = data.clusters[c];
            const std::uint32_t count = seen[cluster.first_patch + cluster.patch_count] - seen[cluster.first_patch];
            mixed[c] = count > 0 && count < cluster.patch_count;
        }
    }
    area_row.assign(data.clusters.size(), kNoNode);
    for (std::size_t k = 0; k < data.area_clusters.size(); ++k)
        area_row[data.area_clusters[k]] = static_cast<std::uint32_t>(k);

    // Shares are smooth where areas have kinks, so they are what is interpolated.
    std::vector<double> running((p_count + 1) * d_count, 0.0);
    for (std::size_t p = 0; p < p_count; ++p)
        for (std::size_t k = 0; k < d_count; ++k)
            running[(p + 1) * d_count + k] = running[p * d_count + k] + double(cosine_area[p * stride + k]);
    const std::size_t rows = data.area_clusters.size();
    whole_share.assign(rows * d_count, 1.0f);
    intrinsic_share.assign(rows * d_count, 1.0f);
    for (std::size_t r = 0; r < rows; ++r) {
        const Cluster& cluster = data.clusters[data.area_clusters[r]];
        const double* from = &running[cluster.first_patch * d_count];
        const double* to = &running[(cluster.first_patch + cluster.patch_count) * d_count];
        const auto set_shares = [&](std::span<const std::uint8_t> table, std::span<const float> scale, std::vector<float>& shares) {
            if (table.empty()) return;
            const auto seen = [&](std::size_t k) { return double(table[r * d_count + k]) * double(scale[r]) / 255; };
            double all_seen = 0, all = 0;
            for (std::size_t k = 0; k < d_count; ++k) all += to[k] - from[k], all_seen += seen(k);
            // Slightly above 1 where few pixels were counted: cut off there, the mean would come out too low.
            const auto share = [](double part, double whole) { return static_cast<float>(std::min(kMostShare, part / whole)); };
            // Where the cluster faces away nothing is known; grazing directions lie between these and such as are.
            const float unknown = all > 0 ? share(all_seen, all) : 1.0f;
            for (std::size_t k = 0; k < d_count; ++k) {
                const double plain = to[k] - from[k];
                shares[r * d_count + k] = plain > 1e-9 * double(cluster.area) ? share(seen(k), plain) : unknown;
            }
        };
        set_shares(data.whole_area, data.whole_area_scale, whole_share);
        set_shares(data.intrinsic_area, data.intrinsic_area_scale, intrinsic_share);
    }
}

EndAreas::EndAreas(const Nodes& nodes, const EndAreas* before) : nodes_(nodes) {
    const Scene& scene = nodes.scene();
    for (const auto& object : scene.objects) {
        std::shared_ptr<const ObjectTables> tables;
        if (before != nullptr) {
            const auto& known = before->nodes_.scene().objects;
            const auto at = std::find(known.begin(), known.end(), object);
            if (at != known.end()) tables = before->tables_[static_cast<std::size_t>(at - known.begin())];
        }
        tables_.push_back(tables ? tables : std::make_shared<ObjectTables>(object->data(), object->archive.grid()));
    }
    for (const Instance& instance : scene.instances)
        for (std::size_t o = 0; o < scene.objects.size(); ++o)
            if (scene.objects[o].get() == instance.object) of_instance_.push_back(tables_[o].get());
}

bool EndAreas::mixed(const Node& node) const {
    return !node.group() && node.kind != NodeKind::Surface && of_instance_[node.instance]->mixed[node.index] != 0;
}

bool EndAreas::has_outside(const Node& node) const {
    if (node.kind == NodeKind::Bins) return true;
    if (node.kind != NodeKind::Flat) return false;
    const Instance& instance = nodes_.scene().instances[node.instance];
    return instance.data().meta.convex || nodes_.instance(node.instance).planar || instance.data().clusters[node.index].right_child == 0 ||
           of_instance_[node.instance]->area_row[node.index] != kNoNode;
}

double EndAreas::visible_share(const Node& node, const Vec3& w, EndMode mode) const {
    if (node.kind == NodeKind::Surface || node.group()) return 1;
    const Instance& instance = nodes_.scene().instances[node.instance];
    const ObjectData& data = instance.data();
    if (data.meta.convex || nodes_.instance(node.instance).planar) return 1;
    const ObjectTables& tables = *of_instance_[node.instance];
    const DirectionGrid& grid = instance.object->archive.grid();
    const Vec3 local = instance.to_local.vector(w);
    const std::uint32_t row = tables.area_row[node.index];
    const Cluster& cluster = data.clusters[node.index];
    const std::size_t d = grid.size();
    if (mode == EndMode::Outside && cluster.right_child == 0)
        return grid.interpolate(data.visibility.subspan(cluster.first_patch * d, d), local) / 255.0;
    // Faces that look one way hardly hide one another, less than small clusters' areas are uncertain by.
    if (row == kNoNode || (mode == EndMode::Inside && node.kind == NodeKind::Flat)) return 1;
    const std::vector<float>& share = mode == EndMode::Outside ? tables.whole_share : tables.intrinsic_share;
    return grid.interpolate(std::span(share).subspan(row * d, d), local);
}

TableError EndAreas::table_error(const Node& node, EndMode mode) const {
    if (node.kind == NodeKind::Surface || mode == EndMode::Mean || (node.kind == NodeKind::Flat && mode == EndMode::Inside))
        return {};
    const ObjectData& data = nodes_.scene().instances[node.instance].data();
    const std::uint32_t row = of_instance_[node.instance]->area_row[node.index];
    if (row == kNoNode) return {kUnmeasured, kUnmeasured};
    const double seen = double(data.visibility_error[row]);
    if (node.kind == NodeKind::Flat) return {seen, seen};
    const double area = double(mode == EndMode::Outside ? data.whole_area_error[row] : data.intrinsic_area_error[row]);
    return {std::max(kLeastError, area), std::max(kLeastError, mode == EndMode::Outside ? seen : area)};
}

template <int C>
DirectionBins<C>::DirectionBins(const Nodes& nodes, const EndAreas& areas)
    : nodes_(nodes), areas_(areas), states_(nodes.scene().instances.size()) {
    reset();
}

template <int C>
void DirectionBins<C>::reset() {
    states_.assign(states_.size(), {});
    for (auto& row : row_) row.assign(nodes_.bins_count(), kNoNode);
    tasks_.clear();
}

template <int C>
void DirectionBins<C>::use(std::uint32_t node, EndMode mode) {
    const Node& n = nodes_[node];
    assert(n.kind == NodeKind::Bins && !n.group());
    const auto m = static_cast<std::size_t>(mode);
    if (row_[m][n.slot] != kNoNode) return;
    row_[m][n.slot] = 0;  // allocate() knows it
    states_[n.instance].face[m].nodes.push_back(node);
    states_[n.instance].grown = true;
}

template <int C>
void DirectionBins<C>::allocate() {
    for (std::uint32_t i = 0; i < states_.size(); ++i)
        if (std::exchange(states_[i].grown, false)) allocate(i);
    tasks_.clear();
    for (std::uint32_t i = 0; i < states_.size(); ++i)
        for (std::uint32_t t = 0; t < states_[i].face[0].terminal.size(); ++t)
            if (states_[i].face[0].terminal[t] != kNoNode || states_[i].face[1].terminal[t] != kNoNode) tasks_.push_back({i, t});
}

template <int C>
void DirectionBins<C>::allocate(std::uint32_t i) {
    State& state = states_[i];
    const Instance& instance = nodes_.scene().instances[i];
    const DirectionGrid& grid = instance.object->archive.grid();
    state.stride = areas_.tables(i).stride;
    const double determinant = std::abs(instance.to_world.linear.determinant());
    state.area_factor.assign(state.stride, 0);
    for (std::uint32_t k = 0; k < grid.size(); ++k)
        state.area_factor[k] = static_cast<float>(determinant / length(instance.to_world.vector(grid.direction(k))));
    for (std::size_t m = 0; m < 2; ++m) {
        Face& face = state.face[m];
        const std::vector<std::uint32_t> known(face.nodes.begin(), face.nodes.begin() + static_cast<std::ptrdiff_t>(face.due.size()));
        number_rows(i, m);
        const std::size_t rows = face.nodes.size(), plane = kIncoming * state.stride;
        std::vector<float> incoming(rows * plane, 0), pushed(remembers_ ? rows * plane : 0, 0);
        for (std::size_t r = 0; r < known.size(); ++r) {
            const std::size_t to = row_[m][nodes_[known[r]].slot];
            std::copy_n(&face.incoming[r * plane], plane, &incoming[to * plane]);
            if (remembers_) std::copy_n(&face.pushed[r * plane], plane, &pushed[to * plane]);
        }
        face.incoming = std::move(incoming);
        face.pushed = std::move(pushed);
        face.intensity.assign(rows * C * state.stride, 0);
        face.due.assign(rows, 1);
        face.arrived.assign(rows, 1);
    }
}

template <int C>
void DirectionBins<C>::number_rows(std::uint32_t i, std::size_t mode) {
    Face& face = states_[i].face[mode];
    const InstanceNodes& in = nodes_.instance(i);
    std::sort(face.nodes.begin(), face.nodes.end());
    for (std::uint32_t r = 0; r < face.nodes.size(); ++r) row_[mode][nodes_[face.nodes[r]].slot] = r;
    const auto nearest = [&](std::uint32_t id) {  // at the node or above it
        for (; id != kNoNode && id >= in.first_cluster; id = nodes_[id].parent)
            if (nodes_[id].kind == NodeKind::Bins && row_[mode][nodes_[id].slot] != kNoNode)
                return row_[mode][nodes_[id].slot];
        return kNoNode;
    };
    face.above.clear();
    face.terminal.clear();
    for (const std::uint32_t id : face.nodes) face.above.push_back(nearest(nodes_[id].parent));
    for (const std::uint32_t t : in.terminals) face.terminal.push_back(nearest(t));
}

template <int C>
void DirectionBins<C>::clear_incoming(std::uint32_t id) {
    const Node& node = nodes_[id];
    State& state = states_[node.instance];
    for (std::size_t m = 0; m < 2; ++m) {
        const std::uint32_t r = row_[m][node.slot];
        if (r == kNoNode) continue;
        Face& face = state.face[m];
        std::fill_n(&face.incoming[r * kIncoming * state.stride], kIncoming * state.stride, 0.0f);
        face.arrived[r] = 1;
    }
}

template <int C>
void DirectionBins<C>::find_due(std::uint32_t i, Face& face, const std::vector<std::uint8_t>& changed) const {
    const InstanceNodes& in = nodes_.instance(i);
    for (std::size_t t = 0; t < in.terminals.size(); ++t) {
        const std::size_t r = face.terminal[t];
        if (r == kNoNode || face.due[r]) continue;
        const auto [first, last] = nodes_.faces(nodes_[in.terminals[t]]);
        const auto from = changed.begin() + in.first_face;
        face.due[r] = std::find(from + first, from + last, 1) != from + last;
    }
    for (std::size_t r = face.nodes.size(); r-- > 0;)
        if (face.due[r] && face.above[r] != kNoNode) face.due[face.above[r]] = 1;
}

template <int C>
void DirectionBins<C>::pull_instance(std::uint32_t i, EndMode mode, const std::vector<float>& radiosity) {
    State& state = states_[i];
    Face& face = state.face[static_cast<std::size_t>(mode)];
    const ObjectData& data = nodes_.scene().instances[i].data();
    const InstanceNodes& in = nodes_.instance(i);
    const ObjectTables& tables = areas_.tables(i);
    const std::size_t stride = state.stride;
    for (std::size_t r = 0; r < face.nodes.size(); ++r)
        if (face.due[r]) std::fill_n(&face.intensity[r * C * stride], C * stride, 0.0f);

    for (std::size_t t = 0; t < in.terminals.size(); ++t) {
        const std::size_t r = face.terminal[t];
        if (r == kNoNode || !face.due[r]) continue;
        const Cluster& cluster = data.clusters[nodes_[in.terminals[t]].index];
        for (std::uint32_t p = cluster.first_patch; p < cluster.first_patch + cluster.patch_count; ++p) {
            const Patch& patch = data.patches[p];
            // Mean radiosity of the patch, by area.
            std::array<float, C> b{};
            double area = 0;
            for (std::uint32_t f = patch.first_face; f < patch.first_face + patch.face_count; ++f) {
                const std::uint32_t id = in.first_face + f;
                area += nodes_[id].area;
                for (std::size_t c = 0; c < C; ++c)
                    b[c] += radiosity[id * C + c] * static_cast<float>(nodes_[id].area);
            }
            if (!(area > 0)) continue;
            const float* cosine = &tables.cosine_area[p * stride];
            const float* visible = &tables.visibility[p * stride];
            for (std::size_t c = 0; c < C; ++c) {
                const float bc = b[c] / static_cast<float>(area) * static_cast<float>(std::numbers::inv_pi);
                if (bc == 0) continue;
                float* out = &face.intensity[(r * C + c) * stride];
                if (mode == EndMode::Inside)
                    for (std::size_t k = 0; k < stride; ++k) out[k] += bc * cosine[k];
                else
                    for (std::size_t k = 0; k < stride; ++k) out[k] += bc * cosine[k] * visible[k];
            }
        }
    }
    for (std::size_t r = 0; r < face.nodes.size(); ++r)
        for (std::size_t c = 0; c < C && face.due[r]; ++c) {
            float* out = &face.intensity[(r * C + c) * stride];
            for (std::size_t k = 0; k < stride; ++k) out[k] *= state.area_factor[k];
        }
    // Nodes above have smaller rows: a backward loop sums them up.
    for (std::size_t r = face.nodes.size(); r-- > 0;) {
        if (face.above[r] == kNoNode || !face.due[face.above[r]]) continue;
        const float* from = &face.intensity[r * C * stride];
        float* to = &face.intensity[face.above[r] * C * stride];
        for (std::size_t k = 0; k < C * stride; ++k) to[k] += from[k];
    }
}

template <int C>
void DirectionBins<C>::pull(const std::vector<float>& radiosity, std::vector<std::uint8_t>& changed) {
    parallel_for(states_.size(), 1, [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        for (std::size_t m = 0; m < 2; ++m) {
            Face& face = states_[i].face[m];
            if (face.nodes.empty()) continue;
            find_due(i, face, changed);
            pull_instance(i, static_cast<EndMode>(m), radiosity);
        }
        // Only now, since nodes may be used in both modes.
        for (Face& face : states_[i].face)
            for (std::size_t r = 0; r < face.nodes.size(); ++r)
                if (std::exchange(face.due[r], std::uint8_t{0})) changed[face.nodes[r]] = 1;
    });
}

template <int C>
std::array<float, C> DirectionBins<C>::intensity(std::uint32_t id, EndMode mode, const Vec3& w) const {
    const Node& node = nodes_[id];
    const State& state = states_[node.instance];
    const Instance& instance = nodes_.scene().instances[node.instance];
    const DirectionTaps taps = instance.object->archive.grid().taps(instance.to_local.vector(w));
    const Face& face = state.face[static_cast<std::size_t>(mode)];
    const float* table = &face.intensity[row(mode, node) * C * state.stride];
    std::array<float, C> out{};
    for (std::size_t c = 0; c < C; ++c)
        for (std::size_t t = 0; t < 4; ++t) out[c] += taps.weight[t] * table[c * state.stride + taps.node[t]];
    return out;
}

template <int C>
void DirectionBins<C>::splat(std::uint32_t id, EndMode mode, const Vec3& u, double inverse_distance,
                             const std::array<float, C>& h) {
    const Node& node = nodes_[id];
    State& state = states_[node.instance];
    const Instance& instance = nodes_.scene().instances[node.instance];
    const DirectionTaps taps = instance.object->archive.grid().taps(instance.to_local.vector(u));
    Face& face = state.face[static_cast<std::size_t>(mode)];
    const std::uint32_t r = row(mode, node);
    face.arrived[r] = 1;
    splat_into(&face.incoming[r * kIncoming * state.stride], state.stride, taps, u, inverse_distance, h);
}

template <int C>
void DirectionBins<C>::push_terminal(std::uint32_t i, std::uint32_t t, EndMode mode,
                                     std::vector<float>& irradiance) const {
    const State& state = states_[i];
    const Face& face = state.face[static_cast<std::size_t>(mode)];
    const std::vector<float>& incoming = remembers_ ? face.pushed : face.incoming;
    const InstanceNodes& in = nodes_.instance(i);
    const std::uint32_t terminal = in.terminals[t];
    const Instance& instance = nodes_.scene().instances[i];
    const DirectionGrid& grid = instance.object->archive.grid();
    const std::size_t stride = state.stride;

    // Planes of this terminal: H[C], then Hu[3].
    std::vector<float> sum((C + 3) * stride, 0.0f);
    for (std::uint32_t r = face.terminal[t]; r != kNoNode; r = face.above[r]) {
        const float* plane = &incoming[r * kIncoming * stride];
        if (face.nodes[r] == terminal) {
            for (std::size_t k = 0; k < (C + 3) * stride; ++k) sum[k] += plane[k];
            continue;
        }
        const Vec3 x = nodes_[terminal].centre - nodes_[face.nodes[r]].centre;
        for (std::size_t k = 0; k < grid.size(); ++k) {
            const float strength = mean_over<C>([&](std::size_t c) { return plane[c * stride + k]; });
            if (!(strength > 0)) continue;
            const Vec3 mean{plane[C * stride + k], plane[(C + 1) * stride + k], plane[(C + 2) * stride + k]};
            const Arrival at_terminal = translated(mean, strength, plane[(C + 3) * stride + k], x);
            const Vec3& direction = at_terminal.direction;
            const DirectionTaps taps = grid.taps(instance.to_local.vector(direction));
            for (std::size_t tap = 0; tap < 4; ++tap) {
                const float weight = taps.weight[tap] * at_terminal.gain;
                float* at = &sum[taps.node[tap]];
                for (std::size_t c = 0; c < C; ++c) at[c * stride] += weight * plane[c * stride + k];
                const float s = weight * strength;
                at[C * stride] += s * static_cast<float>(direction.x);
                at[(C + 1) * stride] += s * static_cast<float>(direction.y);
                at[(C + 2) * stride] += s * static_cast<float>(direction.z);
            }
        }
    }
    for (std::size_t k = 0; k < stride; ++k) {  // Hu -> unit mean direction
        const Vec3 u = normalised({sum[C * stride + k], sum[(C + 1) * stride + k], sum[(C + 2) * stride + k]});
        sum[C * stride + k] = static_cast<float>(u.x);
        sum[(C + 1) * stride + k] = static_cast<float>(u.y);
        sum[(C + 2) * stride + k] = static_cast<float>(u.z);
    }

    const ObjectTables& tables = areas_.tables(i);
    const ObjectData& data = instance.data();
    const Cluster& cluster = data.clusters[nodes_[terminal].index];
    const float* ux = &sum[C * stride];
    const float* uy = ux + stride;
    const float* uz = uy + stride;
    // Blocks of directions that light comes from.
    thread_local std::vector<std::size_t> lit;
    lit.clear();
    for (std::size_t k = 0; k < stride; k += kLanes) {
        float most = 0;
        for (std::size_t c = 0; c < C; ++c)
            for (std::size_t j = 0; j < kLanes; ++j) most = std::max(most, sum[c * stride + k + j]);
        if (most > 0) lit.push_back(k);
    }
    for (std::uint32_t p = cluster.first_patch; p < cluster.first_patch + cluster.patch_count; ++p) {
        const Patch& patch = data.patches[p];
        const float* visible = &tables.visibility[p * stride];
        const auto weigh = [&](const Vec3& normal, std::size_t k, float* weight, bool cosines) {
            const float nx = static_cast<float>(normal.x), ny = static_cast<float>(normal.y), nz = static_cast<float>(normal.z);
            for (std::size_t j = 0; j < kLanes; ++j) {
                const float cosine = nx * ux[k + j] + ny * uy[k + j] + nz * uz[k + j];
                const float facing = cosines ? std::max(0.0f, cosine) : cosine > 0 ? 1.0f : 0.0f;
                weight[j] = facing * (mode == EndMode::Outside ? visible[k + j] : 1.0f);
            }
        };
        if (patch.face_count < kFewFaces) {
            for (std::uint32_t f = patch.first_face; f < patch.first_face + patch.face_count; ++f) {
                const Vec3 n = nodes_[in.first_face + f].normal();
                float lanes[C][kLanes] = {};
                for (const std::size_t k : lit) {
                    float weight[kLanes];
                    weigh(n, k, weight, true);
                    for (std::size_t c = 0; c < C; ++c)
                        for (std::size_t j = 0; j < kLanes; ++j) lanes[c][j] += weight[j] * sum[c * stride + k + j];
                }
                for (std::size_t c = 0; c < C; ++c) irradiance[(in.first_face + f) * C + c] += total(lanes[c]);
            }
            continue;
        }
        // Faces that look nearly one way share one irradiance vector and meet it with their own cosines.
        float lanes[3 * C][kLanes] = {};
        std::uint32_t whole = nodes_[in.first_face + patch.first_face].parent;
        while (nodes_[whole].part()) whole = nodes_[whole].parent;
        const Vec3 mean = nodes_[whole].normal();
        for (const std::size_t k : lit) {
            float weight[kLanes];
            weigh(mean, k, weight, false);
            for (std::size_t c = 0; c < C; ++c)
                for (std::size_t j = 0; j < kLanes; ++j) {
                    const float h = weight[j] * sum[c * stride + k + j];
                    lanes[3 * c][j] += h * ux[k + j];
                    lanes[3 * c + 1][j] += h * uy[k + j];
                    lanes[3 * c + 2][j] += h * uz[k + j];
                }
        }
        for (std::size_t c = 0; c < C; ++c) {
            const Vec3 v{total(lanes[3 * c]), total(lanes[3 * c + 1]), total(lanes[3 * c + 2])};
            for (std::uint32_t f = patch.first_face; f < patch.first_face + patch.face_count; ++f)
                irradiance[(in.first_face + f) * C + c] +=
                    static_cast<float>(std::max(0.0, dot(nodes_[in.first_face + f].normal(), v)));
        }
    }
}

template <int C>
void DirectionBins<C>::find_arrived(Face& face, std::size_t stride, double tolerance) const {
    const std::size_t plane = kIncoming * stride;
    for (std::size_t r = 0; r < face.nodes.size(); ++r) {
        if (!face.arrived[r]) continue;
        const float *now = &face.incoming[r * plane], *then = &face.pushed[r * plane];
        double change = 0;
        for (std::size_t k = 0; k < stride; ++k)
            change += mean_over<C>([&](std::size_t c) { return std::abs(double(now[c * stride + k]) - double(then[c * stride + k])); });
        face.arrived[r] = change > tolerance;
        if (face.arrived[r]) std::copy_n(now, plane, &face.pushed[r * plane]);
    }
}

template <int C>
std::vector<std::uint8_t> DirectionBins<C>::push(std::vector<float>& irradiance, double tolerance) {
    if (remembers_)
        parallel_for(states_.size(), 1, [&](std::size_t i) {
            for (Face& face : states_[i].face) find_arrived(face, states_[i].stride, tolerance);
        });
    std::vector<std::uint8_t> reached(states_.size(), 0);
    std::vector<Task> due;
    for (const Task& task : tasks_) {
        bool arrived = false;
        for (const Face& face : states_[task.instance].face)
            for (std::uint32_t r = face.terminal[task.terminal]; r != kNoNode; r = face.above[r]) arrived = arrived || face.arrived[r];
        if (!arrived) continue;
        due.push_back(task);
        reached[task.instance] = 1;
    }
    parallel_for(due.size(), 1, [&](std::size_t k) {
        const auto [i, t] = due[k];
        const InstanceNodes& in = nodes_.instance(i);
        const auto [first, last] = nodes_.faces(nodes_[in.terminals[t]]);
        std::fill_n(&irradiance[(in.first_face + first) * C], (last - first) * C, 0.0f);
        for (std::size_t m = 0; m < 2; ++m)
            if (states_[i].face[m].terminal[t] != kNoNode)
                push_terminal(i, t, static_cast<EndMode>(m), irradiance);
    });
    for (State& state : states_)
        for (Face& face : state.face) std::fill(face.arrived.begin(), face.arrived.end(), std::uint8_t{0});
    return reached;
}

template <int C>
std::uint64_t DirectionBins<C>::bytes() const {
    std::uint64_t n = 0;
    for (const State& s : states_)
        for (const Face& face : s.face) n += (face.intensity.size() + face.incoming.size() + face.pushed.size()) * sizeof(float);
    return n;
}

template class DirectionBins<1>;
template class DirectionBins<3>;

}  // namespace rro
