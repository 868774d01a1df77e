// What all passes of a solve stand on, and how it moves with the scene.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "solver/transport/gather.h"
#include "solver/transport/node_map.h"
#include "solver/transport/outside_light.h"

namespace rro {

/// Of one scene. Holds references to its own parts: neither copied nor moved.
template <int C>
struct Stage {
    Stage(std::shared_ptr<const Scene> of, const Plan& plan, const TransportOptions& options)
        : place(std::move(of)), scene(place), nodes(*scene), areas(nodes), field(nodes, areas) {
        look(plan, options);
    }
    Stage(std::shared_ptr<const Scene> of, const Plan& plan, const TransportOptions& options, const Stage& before,
          const UsedElements& used, const SceneChange& change)
        : place(std::move(of)), scene(place), nodes(*scene), map(carry_nodes(before.nodes, used, change, nodes)), areas(nodes, &before.areas),
          field(nodes, areas) {
        look(plan, options);
        field.take_over(before.field, map);
    }

    /// Instances stand elsewhere, as Nodes::move allows it.
    void move(std::shared_ptr<const Scene> to, const Plan& plan, const TransportOptions& options, const std::vector<std::uint8_t>& moved) {
        place = scene = std::move(to);
        nodes.move(*scene, moved);
        look(plan, options);
    }

    std::shared_ptr<const Scene> place;  // what rays and links refer to
    std::shared_ptr<const Scene> scene;  // the same, or with the materials it has by now
    Nodes nodes;
    std::vector<std::uint32_t> map;  // [nodes before] their numbers
    EndAreas areas;
    LightField<C> field;
    std::optional<SceneRays> rays;  // these three: made by look() at the scene as it stands
    std::optional<LinkBuilder> builder;
    std::optional<OutsideLight> outside;

  private:
    void look(const Plan& plan, const TransportOptions& options) {
        rays.emplace(*scene);
        builder.emplace(nodes, areas, *rays, options);
        outside.emplace(*scene, plan, *builder, *rays, options);
    }
};

}  // namespace rro
