// Dimmed light groups, written into a manifest.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "solver/edit/manifest_edit.h"
#include "solver/scene/scene.h"

namespace rro {

using GroupScales = std::map<std::string, double, std::less<>>;  // >= 0, by light group

/// The manifest in which everything of a group gives `scale` times as much light; other bytes stay.
///
/// scene    the same manifest, opened
/// errors   BadInput: an archive with several materials of one name in a group, which a manifest cannot tell apart
Result<std::string> with_group_scales(const ManifestText& manifest, const Scene& scene, const GroupScales& scales);

}  // namespace rro
