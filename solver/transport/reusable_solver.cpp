#include "solver/transport/reusable_solver.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "format/clock.h"
#include "solver/transport/dimming.h"
#include "solver/transport/fill_guide.h"
#include "solver/transport/retest.h"
#include "solver/transport/stage.h"

namespace rro {
namespace {

constexpr int kMostRounds = 9;
// Divisions of one face at the edges of shadows from sky, sun and lamps, before any link is made.
constexpr int kShadowLevels = 6;
// Light that only steers refinement may be this part of the accuracy away from converged.
constexpr double kSteering = 0.3;
// Light of the first rounds only steers refinement: direct light, one bounce, then converged.
constexpr int kDirectRounds = 1;
// How much of the squared error one link may bring at first; later rounds learn it from the estimate.
constexpr double kFirstShare = 1.0 / 1000;
constexpr double kCoarseAccuracy = 0.3;
constexpr int kInstanceRounds = 1;  // for single instances that err too much, while the scene does not
// Where edits have moved more than this part of the scene (by the squared diagonals of its instances' boxes), or links have
// become more than this many times those of the last solve from scratch, there is nothing left to be saved.
constexpr double kMostMoved = 0.5, kMostGrowth = 1.5;
// Elements that links need no more stay until there are this many times the nodes of the last time they were looked for.
constexpr double kMostElements = 1.2;
// Changes of radiosity below this part of the accuracy, relative to the scene's reflected light, wait for more.
constexpr double kUnsent = 0.02;
// Links may err by this part of the accuracy: a tenth is left to the iteration, added by squares.
constexpr double kSettled = 0.99;

/// Does one plan lead to the same passes as another?
bool same_passes(const Plan& a, const Plan& b) {
    const auto same = [&](const char* effect) { return a.on(effect) == b.on(effect); };
    return a.channels == b.channels && same("interreflection") && same("occlusion") && same("self") && same("sky") &&
           same("sun") && same("lights") && same("transmission") && same("medium");
}

bool same_options(const TransportOptions& a, const TransportOptions& b) {
    return a.accuracy == b.accuracy && a.seed == b.seed && a.visibility == b.visibility && a.far_factor == b.far_factor;
}

}  // namespace

/// A scene being solved.
struct ReusableSolver::State {
    virtual ~State() = default;
    virtual Solution solve(const Progress& progress) = 0;
    virtual bool can_follow(const Scene& scene, const SceneChange& change) const = 0;
    virtual Solution follow(std::shared_ptr<const Scene> scene, const SceneChange& change, const Progress& progress) = 0;
    virtual const Scene& scene() const = 0;
    virtual const LinkChange& links() const = 0;
    virtual std::size_t link_count() const = 0;
    virtual std::uint64_t bytes() const = 0;

    Plan plan;
    TransportOptions options;
};

namespace {

template <int C>
class Engine : public ReusableSolver::State {
  public:
    Engine(std::shared_ptr<const Scene> scene, const Plan& plan_, const TransportOptions& options_, bool follows) {
        plan = plan_;
        options = options_;
        const auto start = Clock::now();
        stage_ = std::make_unique<Stage<C>>(std::move(scene), plan, options);
        set_ = std::make_unique<LinkSet>(stage_->nodes, plan.on("self"), follows);
        if (follows) stage_->field.follow();
        guide_.share.assign(stage_->scene->instances.size(), std::pow(std::max(kCoarseAccuracy, options.accuracy), 2) * kFirstShare);
        guide_.scene_share = guide_.share.empty() ? 0 : guide_.share[0];
        first_seconds_ = seconds_since(start);
    }

    Solution solve(const Progress& progress) override {
        Solution solution;
        solution.seconds.links += first_seconds_;
        sources_ = sources_of(stage_->nodes, stage_->field);
        find_outside(true, solution, progress);
        if (stage_->outside->any()) stage_->field.begin();
        guide_.error.assign(stage_->nodes.size(), 0.0f);
        fill_guide(stage_->nodes, stage_->field, guide_);
        guide_.reflected = reflected_at_first();
        if (set_->tree) schedule_.first = guide_;
        settle(0, Links::None, solution, progress);
        links_at_first_ = set_->links.size();
        nodes_at_first_ = stage_->nodes.size();
        return solution;
    }

    bool can_follow(const Scene& scene, const SceneChange& change) const override {
        if (change.surroundings || double(set_->links.size()) > kMostGrowth * double(links_at_first_)) return false;
        double moved = 0, all = 0;
        for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
            const double extent = length2(scene.instances[i].bounds.extent());
            all += extent;
            if (change.moved[i]) moved += extent;
        }
        return moved <= kMostMoved * all;
    }

    Solution follow(std::shared_ptr<const Scene> scene, const SceneChange& change, const Progress& progress) override {
        Solution solution;
        const auto start = Clock::now();
        set_->change = {};
        set_->rays = 0;
        set_->visibility_seconds = 0;
        if (change.only_materials() && !stage_->outside->any()) {
            follow_materials(std::move(scene), change, solution, progress);
            return solution;
        }
        dimming_.catch_up(*stage_, *stage_->scene);
        dimming_.forget();
        if (stays_in_place(*scene, change)) {
            const std::shared_ptr<const Scene> before = stage_->scene;
            stage_->move(std::move(scene), plan, options, change.moved);
            if (sources_changed_) {
                sources_ = sources_of(stage_->nodes, stage_->field);
                begin_guides();
            }
            guide_.share = schedule_.rounds.back().of_instance;
            guide_.scene_share = schedule_.rounds.back().of_scene;
            solution.seconds.links += seconds_since(start);
            judge_again(touched_by(change, *before, stage_->nodes), solution);
            settle(kDirectRounds, Links::Ready, solution, progress);
            return solution;
        }
        const std::unique_ptr<Stage<C>> before = std::move(stage_);
        const bool same_outside = !change.places() && !change.lights;
        UsedElements used = used_elements(*set_, before->nodes);
        // What fell on their faces as a whole may never have been looked at.
        if (same_outside && before->outside->any()) used.assign(used.size(), 1);
        stage_ = std::make_unique<Stage<C>>(std::move(scene), plan, options, *before, used, change);
        stage_->field.follow();
        nodes_at_first_ = stage_->nodes.size();
        renumber(*set_, stage_->map);
        sources_ = sources_of(stage_->nodes, stage_->field);
        carry(guide_, schedule_, stage_->map, change, stage_->nodes);
        if (same_outside && before->outside->any()) stage_->outside->take_over(*before->outside, stage_->map);
        solution.seconds.links += seconds_since(start);
        find_outside(!same_outside, solution, progress);
        begin_guides();
        if (change.places()) {
            const auto renewed = std::span(stage_->map).first(before->nodes.group_count());
            judge_again(touched_by(change, *before->scene, stage_->nodes, renewed), solution);
        }
        const bool placed = std::find(change.before.begin(), change.before.end(), SceneChange::kPlaced) != change.before.end();
        settle(kDirectRounds, placed ? Links::Retested : Links::Ready, solution, progress);
        return solution;
    }

    const Scene& scene() const override { return *stage_->scene; }
    const LinkChange& links() const override { return set_->change; }
    std::size_t link_count() const override { return set_->links.size(); }
    std::uint64_t bytes() const override {
        return set_->links.size() * sizeof(Link) + stage_->field.bytes() + stage_->nodes.size() * sizeof(Node) +
               (set_->tree ? set_->tree->bytes() : 0);
    }

  private:
    /// Before any light has been gathered: all emitted power spread evenly and reflected once.
    double reflected_at_first() const {
        return sources_.area > 0 ? sources_.emitted * sources_.emitted / sources_.area * 0.25 + entering_ : entering_;
    }

    /// Light from outside comes first: it is a source like emitters, and its shadows divide faces.
    void find_outside(bool anew, Solution& solution, const Progress& progress) {
        Nodes& nodes = stage_->nodes;
        LightField<C>& field = stage_->field;
        OutsideLight& outside = *stage_->outside;
        const auto start = Clock::now();
        guide_.area = sources_.area;
        entering_ = 0;
        if (!outside.any()) return;
        if (progress) progress("sky, sun and lamps", 0);
        outside.find(nodes);
        for (int level = 0; anew && level < kShadowLevels; ++level) {
            guide_.reflected = reflected_once(nodes, outside.irradiance());
            const std::vector<std::uint32_t> edges = outside.shadow_edges(nodes, guide_);
            if (edges.empty()) break;
            for (const std::uint32_t id : edges) nodes.subdivide(id);
            outside.find(nodes);
        }
        entering_ = reflected_once(nodes, outside.irradiance());
        field.grow();
        field.set_outside(outside.irradiance());
        solution.seconds.outside = seconds_since(start);
    }

    /// No link changes. Where whole light groups are dimmed, not even a sweep is needed; where it is one that has been dimmed
    /// before, nothing but a sum.
    void follow_materials(std::shared_ptr<const Scene> scene, const SceneChange& change, Solution& solution, const Progress& progress) {
        auto start = Clock::now();
        const std::shared_ptr<const Scene> before = std::exchange(stage_->scene, std::move(scene));
        const std::vector<std::uint32_t> changed = changed_groups(*before, *stage_->scene);
        sources_changed_ = true;
        const bool sums = !change.reflectance && plan.on("interreflection");
        if (sums && dimming_.again(*stage_->scene, changed, sources_.area, kSettled * options.accuracy, options.accuracy, solution)) {
            stage_->nodes.set_materials(*stage_->scene);
            solution.seconds.iterate += seconds_since(start);
            return;
        }
        dimming_.catch_up(*stage_, *before);
        const bool dimmed =
            sums && dimming_.dim({*stage_, *set_, guide_, sources_, options.accuracy, closed(), residual_}, before, changed);
        stage_->nodes.set_materials(*stage_->scene);
        if (!dimmed) dimming_.forget();
        sources_ = sources_of(stage_->nodes, stage_->field);
        stage_->field.relight();
        solution.seconds.iterate += seconds_since(start);
        guide_.share = schedule_.rounds.back().of_instance;
        guide_.scene_share = schedule_.rounds.back().of_scene;
        settle(kDirectRounds, dimmed ? Links::Lit : Links::Swept, solution, progress);
        if (dimmed) dimming_.remember(*stage_->scene, changed, solution, std::pow(error_, 2) * guide_.reflected, guide_.reflected);
    }

    /// The guides of the first round and of later ones, before retest.
    void begin_guides() {
        sources_changed_ = false;
        const LightField<C>& field = stage_->field;
        stage_->field.fill_sources(schedule_.first);
        schedule_.first.error.assign(stage_->nodes.size(), 0.0f);
        schedule_.first.reflected = reflected_at_first();
        fill_guide(stage_->nodes, field, guide_);
        grow_errors();
        guide_.share = schedule_.rounds.back().of_instance;
        guide_.scene_share = schedule_.rounds.back().of_scene;
    }
    void grow_errors() {
        for (auto n = static_cast<std::uint32_t>(guide_.error.size()); n < stage_->nodes.size(); ++n)
            guide_.error.push_back(guide_.error[stage_->nodes[n].parent]);
    }

    /// Do nodes and light keep their numbers?
    bool stays_in_place(const Scene& scene, const SceneChange& change) const {
        const Nodes& nodes = stage_->nodes;
        return change.only_places() && !stage_->outside->any() && double(nodes.size()) <= kMostElements * double(nodes_at_first_) &&
               same_shapes(*stage_->scene, scene, change) && (nodes.group_count() == 0 || group_instances(scene) == nodes.groups());
    }

    void judge_again(const Touched& touched, Solution& solution) {
        const auto start = Clock::now();
        retest(*set_, stage_->nodes, *stage_->builder, schedule_, guide_, touched);
        solution.seconds.links += seconds_since(start);
    }

    /// Pairs that wait for light although it has reached them: a little of it comes last of all.
    std::ptrdiff_t lit_pending() const {
        return std::count_if(set_->pending.begin(), set_->pending.end(), [&](const Pair& pair) {
            return guide_.radiosity[pair.a] > 0 || guide_.radiosity[pair.b] > 0;
        });
    }

    /// Makes the light field carry the links as they are.
    void prepare_sweeps(bool follows) {
        LightField<C>& field = stage_->field;
        OutsideLight& outside = *stage_->outside;
        if (outside.any()) {
            outside.find(stage_->nodes);
            field.set_outside(outside.irradiance());
        }
        if (follows) field.change_links(set_->links, set_->ends);
        else field.set_links(set_->links);
        set_->ends.clear();
        field.bound_rows();
        if (closed()) field.close_rows();
    }

    // A medium takes from every row.
    bool closed() const { return plan.on("self") && is_closed_shell(*stage_->scene) && !stage_->scene->medium; }

    /// What the first round of settle() finds: nothing; links that were judged without the light of what was placed; links;
    /// links; links that the light field carries already, light of other materials; links and light.
    enum class Links { None, Retested, Ready, Swept, Lit };

    /// Rounds of linking and iterating until the estimate fits.
    void settle(int round, Links links, Solution& solution, const Progress& progress) {
        LightField<C>& field = stage_->field;
        const Nodes& nodes = stage_->nodes;
        const bool bounces = plan.on("interreflection"), follows = links != Links::None;
        const double allowed = kSettled * options.accuracy;
        solution.accuracy = options.accuracy;
        double error = 0;
        // Rounds for single instances were spent when the scene was solved from scratch.
        int settled = follows ? kInstanceRounds : 0;
        Residual residual{0, residual_.relative};
        HindSight hind_sight;
        for (const int first = round; round < kMostRounds; ++round) {
            const bool ready = follows && round == first;
            if (progress) progress("links", double(round) / kMostRounds);
            auto start = Clock::now();
            if (set_->tree && !follows) schedule_.rounds.push_back({guide_.share, guide_.scene_share});
            set_->round = static_cast<std::uint8_t>(std::max<std::size_t>(schedule_.rounds.size(), 1) - 1);
            const std::size_t before = nodes.size(), links_before = set_->links.size();
            const std::uint64_t rays_before = set_->rays;
            if (!ready) dimming_.forget();
            if (!ready) refine(*set_, stage_->nodes, guide_, *stage_->builder);
            field.grow();
            field.leave_unsent(follows ? kUnsent * options.accuracy : 0);
            if (!ready || links < Links::Swept) prepare_sweeps(follows);
            bool changed = nodes.size() != before || set_->links.size() != links_before || set_->rays != rays_before;
            solution.seconds.links += seconds_since(start);

            if (progress) progress("iterate", double(round) / kMostRounds);
            start = Clock::now();
            if (!bounces) field.extinguish();
            const int most = !bounces ? 1 : round < kDirectRounds ? 2 : kMostSweeps;
            if (!ready || links != Links::Lit)
                residual = iterate(field, kSteering * options.accuracy, sources_.largest_reflectance, most);
            if (!bounces) residual.relative = 0;  // one sweep is all there is
            solution.iterations += residual.sweeps;
            solution.seconds.iterate += seconds_since(start);

            fill_guide(stage_->nodes, field, guide_);
            ErrorEstimate estimate = estimate_error(*set_, nodes, closed() ? 1.0 : amplification(nodes, field, *stage_->outside),
                                                    stage_->outside->error(), guide_);
            hind_sight.correct(estimate, nodes, field);
            error = estimate.whole;
            solution.worst_instance = worst_instance(estimate);
            if (solution.worst_instance >= 0)
                solution.worst_estimate = estimate.of_instance[static_cast<std::size_t>(solution.worst_instance)];
            if (ready) changed = links == Links::Retested || lit_pending() > lit_pending_;
            if (round < kDirectRounds) continue;
            const bool good = lower_shares(estimate, allowed, guide_);
            if (error <= allowed) ++settled;
            if ((good || settled > kInstanceRounds) && !(changed && round < kDirectRounds + 1)) break;
        }
        if (bounces && residual.relative > options.accuracy / 10) {
            const auto start = Clock::now();
            residual = iterate(field, options.accuracy / 10, sources_.largest_reflectance, kMostSweeps);
            solution.iterations += residual.sweeps;
            solution.seconds.iterate += seconds_since(start);
        }
        residual_ = residual;
        error_ = error;
        lit_pending_ = lit_pending();
        solution.residual = residual.relative;
        solution.estimated_error = std::hypot(error, residual.relative);
        solution.converged = solution.estimated_error <= options.accuracy;
        report(solution);
    }

    void report(Solution& solution) const {
        const Nodes& nodes = stage_->nodes;
        solution.rays = set_->rays + stage_->outside->rays();
        solution.seconds.visibility = set_->visibility_seconds + solution.seconds.outside;
        solution.seconds.links -= set_->visibility_seconds;
        for (const Link& l : set_->links) {
            if (!nodes[l.a].group() && nodes[l.a].instance == nodes[l.b].instance) ++solution.links.self;
            else ++(l.mean() ? solution.links.near : solution.links.far);
        }
        solution.links.bytes = set_->links.size() * sizeof(Link) + stage_->field.bytes();
        store_light(nodes, stage_->field, stage_->outside->irradiance(), solution);
    }

    std::unique_ptr<Stage<C>> stage_;
    std::unique_ptr<LinkSet> set_;
    Guide guide_;
    Schedule schedule_;
    Sources sources_;
    Dimming<C> dimming_;                          // over the links as they are
    std::ptrdiff_t lit_pending_ = 0;              // when the last solve ended
    Residual residual_;                           // of the light as it is
    double error_ = 0;                            // estimated, of the links alone
    bool sources_changed_ = false;                // since begin_guides()
    double entering_ = 0;  // sum of A R^2 of light from outside, reflected once, W^2/m^2
    double first_seconds_ = 0;
    std::size_t links_at_first_ = 0, nodes_at_first_ = 0;
};

TransportOptions effective(TransportOptions options, const Plan& plan) {
    if (!plan.on("occlusion")) options.visibility = VisibilityMethod::None;
    return options;
}

std::unique_ptr<ReusableSolver::State> make_state(std::shared_ptr<const Scene> scene, const Plan& plan,
                                                  const TransportOptions& options, bool follows) {
    if constexpr (built_in("colour"))
        if (plan.channels == 3) return std::make_unique<Engine<3>>(std::move(scene), plan, options, follows);
    return std::make_unique<Engine<1>>(std::move(scene), plan, options, follows);
}

}  // namespace

ReusableSolver::ReusableSolver() = default;
ReusableSolver::~ReusableSolver() = default;
ReusableSolver::ReusableSolver(ReusableSolver&&) noexcept = default;
ReusableSolver& ReusableSolver::operator=(ReusableSolver&&) noexcept = default;

std::uint64_t ReusableSolver::bytes() const { return state_ ? state_->bytes() : 0; }

Result<Solution> ReusableSolver::solve(std::shared_ptr<const Scene> scene, const Plan& plan, const TransportOptions& options,
                                       const Progress& progress) {
    const TransportOptions asked = effective(options, plan);
    if (state_ && same_options(state_->options, asked) && same_passes(state_->plan, plan)) {
        const SceneChange change = scene_change(state_->scene(), *scene);
        if (state_->can_follow(*scene, change)) {
            // What fails on the way leaves nothing to follow from.
            std::unique_ptr<State> state = std::move(state_);
            Solution solution = state->follow(std::move(scene), change, progress);
            change_ = state->links();
            from_scratch_ = false;
            state_ = std::move(state);
            return solution;
        }
    }
    const std::uint64_t removed = state_ ? state_->link_count() : 0;
    state_.reset();  // before there is another one
    std::unique_ptr<State> state = make_state(std::move(scene), plan, asked, true);
    Solution solution = state->solve(progress);
    change_ = {removed, 0, state->link_count()};
    from_scratch_ = true;
    state_ = std::move(state);
    return solution;
}

Result<Solution> solve_reusable(const Scene& scene, const Plan& plan, const TransportOptions& options,
                                const Progress& progress) {
    // The caller's scene outlives the solve.
    const std::shared_ptr<const Scene> borrowed(std::shared_ptr<void>(), &scene);
    return make_state(borrowed, plan, effective(options, plan), false)->solve(progress);
}

}  // namespace rro
