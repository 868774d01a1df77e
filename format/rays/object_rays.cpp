#include "format/rays/object_rays.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace rro {
namespace {

constexpr unsigned kPacket = 16;
constexpr int kActive = -1;  // Embree's mask value of a ray that takes part
constexpr int kInactive = 0;

// How Embree cuts a build into tasks decides the order of triangles in its leaves, and so which of two coinciding
// triangles is hit. It cuts by the number of slots of its task arena, so that number is fixed, whatever the machine and
// set_thread_count. All slots are for callers, none for workers: an object is built by the thread that asks for it, and
// up to this many at a time.
constexpr int kBuildSlots = 16;

std::atomic<std::int64_t> held_bytes{0};

bool count_bytes(void*, ssize_t bytes, bool) {
    held_bytes.fetch_add(bytes, std::memory_order_relaxed);
    return true;  // never refuse an allocation
}

thread_local RTCError last_error = RTC_ERROR_NONE;

void keep_error(void*, RTCError code, const char*) {
    last_error = code;
}

/// Throws what Embree complained about on this thread since the last call.
void check_embree() {
    const RTCError code = std::exchange(last_error, RTC_ERROR_NONE);
    if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (code != RTC_ERROR_NONE) throw std::runtime_error("Embree reports error " + std::to_string(code));
}

/// The process's device. Never released: objects may outlive any static that would own it.
RTCDevice device() {
    static const RTCDevice the_device = [] {
        RTCDevice created = nullptr;
        // Embree gives its own arena as many slots as the arena that it is called in.
        const std::string config = "user_threads=" + std::to_string(kBuildSlots);
        tbb::task_arena(kBuildSlots, kBuildSlots).execute([&] { created = rtcNewDevice(config.c_str()); });
        if (!created) throw std::runtime_error("Embree does not run on this machine");
        rtcSetDeviceErrorFunction(created, keep_error, nullptr);
        rtcSetDeviceMemoryMonitorFunction(created, count_bytes, nullptr);
        return created;
    }();
    return the_device;
}

bool ignores_any(const IgnoredTriangles& ignored) {
    return ignored.a != kNoTriangle || ignored.b != kNoTriangle || ignored.range0_begin < ignored.range0_end ||
           ignored.range1_begin < ignored.range1_end;
}

/// Embree's context with what our filters need behind it; Embree hands the same pointer to the filter.
struct IgnoringContext {
    RTCIntersectContext embree;
    const IgnoredTriangles* ignored;

    IgnoringContext(RTCIntersectContextFlags flags, const IgnoredTriangles& triangles) : ignored(&triangles) {
        rtcInitIntersectContext(&embree);
        embree.flags = flags;
        if (ignores_any(triangles)) embree.filter = reject_ignored;
    }

    static void reject_ignored(const RTCFilterFunctionNArguments* args) {
        const auto* self = reinterpret_cast<const IgnoringContext*>(args->context);
        for (unsigned i = 0; i < args->N; ++i)
            if (args->valid[i] != kInactive && self->ignored->covers(RTCHitN_primID(args->hit, args->N, i)))
                args->valid[i] = kInactive;
    }
};

void fill(RTCRay& r, const ObjectRay& ray) {
    r.org_x = ray.origin.x, r.org_y = ray.origin.y, r.org_z = ray.origin.z;
    r.dir_x = ray.direction.x, r.dir_y = ray.direction.y, r.dir_z = ray.direction.z;
    r.tnear = ray.t_min, r.tfar = ray.t_max;
    r.time = 0, r.mask = 0xffffffffu, r.id = 0, r.flags = 0;
}

void fill(RTCRay16& r, unsigned lane, const ObjectRay& ray) {
    r.org_x[lane] = ray.origin.x, r.org_y[lane] = ray.origin.y, r.org_z[lane] = ray.origin.z;
    r.dir_x[lane] = ray.direction.x, r.dir_y[lane] = ray.direction.y, r.dir_z[lane] = ray.direction.z;
    r.tnear[lane] = ray.t_min, r.tfar[lane] = ray.t_max;
    r.time[lane] = 0, r.mask[lane] = 0xffffffffu, r.id[lane] = lane, r.flags[lane] = 0;
}

}  // namespace

struct ObjectRays::Impl {
    RTCScene scene = nullptr;

    Impl() = default;
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl() {
        if (scene) rtcReleaseScene(scene);
    }
};

ObjectRays::ObjectRays(std::span<const Vec3f> positions, std::span<const TriangleIndices> triangles)
    : impl_(std::make_unique<Impl>()) {
    impl_->scene = rtcNewScene(device());
    check_embree();
    rtcSetSceneBuildQuality(impl_->scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(impl_->scene,
                     static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
    if (!triangles.empty()) {
        const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
        // Buffers of Embree's own are padded for its 16-byte loads, which a view into an archive need not be.
        void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f),
                                                 positions.size());
        void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                sizeof(TriangleIndices), triangles.size());
        if (vertices && indices) {
            std::copy(positions.begin(), positions.end(), static_cast<Vec3f*>(vertices));
            std::copy(triangles.begin(), triangles.end(), static_cast<TriangleIndices*>(indices));
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(impl_->scene, geometry);
        }
        rtcReleaseGeometry(geometry);
        check_embree();
    }
    rtcCommitScene(impl_->scene);
    check_embree();
}

ObjectRays::~ObjectRays() = default;
ObjectRays::ObjectRays(ObjectRays&&) noexcept = default;
ObjectRays& ObjectRays::operator=(ObjectRays&&) noexcept = default;

ObjectHit ObjectRays::first_hit(const ObjectRay& ray, const IgnoredTriangles& ignored) const {
    IgnoringContext context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, ignored);
    RTCRayHit query;
    fill(query.ray, ray);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(impl_->scene, &context.embree, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return {query.hit.primID, query.ray.tfar, query.hit.u, query.hit.v};
}

bool ObjectRays::occluded(const ObjectRay& ray, const IgnoredTriangles& ignored) const {
    IgnoringContext context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, ignored);
    RTCRay query;
    fill(query, ray);
    rtcOccluded1(impl_->scene, &context.embree, &query);
    return query.tfar < 0;  // Embree's mark of a blocked ray
}

void ObjectRays::occluded(std::span<const ObjectRay> rays, std::span<std::uint8_t> blocked,
                          const IgnoredTriangles& ignored) const {
    assert(rays.size() == blocked.size());
    IgnoringContext context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, ignored);
    RTCRay16 packet{};  // idle lanes hold numbers too: what the stack holds may take a slow way through the processor
    alignas(64) int valid[kPacket];
    std::size_t ray_of_lane[kPacket];
    for (std::size_t next = 0; next < rays.size();) {
        unsigned lanes = 0;
        for (; next < rays.size() && lanes < kPacket; ++next) {
            if (blocked[next]) continue;
            ray_of_lane[lanes] = next;
            fill(packet, lanes++, rays[next]);
        }
        if (lanes == 0) break;
        for (unsigned lane = 0; lane < kPacket; ++lane) valid[lane] = lane < lanes ? kActive : kInactive;
        rtcOccluded16(valid, impl_->scene, &context.embree, &packet);
        for (unsigned lane = 0; lane < lanes; ++lane) blocked[ray_of_lane[lane]] = packet.tfar[lane] < 0;
    }
}

void ObjectRays::first_hits(std::span<const ObjectRay> rays, std::span<ObjectHit> hits) const {
    assert(rays.size() == hits.size());
    const IgnoredTriangles none;
    IgnoringContext context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT, none);
    RTCRayHit16 packet{};
    alignas(64) int valid[kPacket];
    for (std::size_t first = 0; first < rays.size(); first += kPacket) {
        const std::size_t lanes = std::min<std::size_t>(kPacket, rays.size() - first);
        for (unsigned lane = 0; lane < kPacket; ++lane) {
            valid[lane] = lane < lanes ? kActive : kInactive;
            packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
            if (lane < lanes) fill(packet.ray, lane, rays[first + lane]);
        }
        rtcIntersect16(valid, impl_->scene, &context.embree, &packet);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const bool hit = packet.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
            hits[first + lane] =
                hit ? ObjectHit{packet.hit.primID[lane], packet.ray.tfar[lane], packet.hit.u[lane], packet.hit.v[lane]}
                    : ObjectHit{};
        }
    }
}

std::uint64_t ObjectRays::memory_bytes() {
    return static_cast<std::uint64_t>(std::max<std::int64_t>(0, held_bytes.load(std::memory_order_relaxed)));
}

}  // namespace rro
