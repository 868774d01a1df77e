// Luminous intensity by direction, as measured and published for lamps: IES LM-63 files.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "format/geometry.h"
#include "format/result.h"

namespace rro {

/// A photometric web of type C: intensity over vertical angles (0 along the lamp's axis, downwards as a rule) and
/// horizontal angles about it. What the symmetry of the file leaves out is filled in when it is asked for.
struct IesDistribution {
    std::vector<double> vertical;    // [V] degrees, ascending, within 0 to 180
    std::vector<double> horizontal;  // [H] degrees, ascending, within 0 to 360
    std::vector<double> candela;     // [H * V], multiplier and ballast factor applied

    /// Bilinear between the angles of the file; 0 outside its vertical angles. Both angles in degrees; the horizontal one
    /// may be any.
    double intensity(double vertical_degrees, double horizontal_degrees) const;
    double largest() const;  // cd
};

/// Reads LM-63 of 1986 to 2019.
///
/// name     stands in messages
/// errors   BadInput: not LM-63, another type than C, a tilt that is in another file, counts beyond what the text holds,
///          angles that do not ascend, an intensity that is no number of at least 0, none above 0
Result<IesDistribution> parse_ies(std::string_view text, const std::string& name);
/// The same from a file.
/// errors   BadInput besides: cannot be read, more than 16 MiB
Result<IesDistribution> read_ies(const std::filesystem::path& path);

}  // namespace rro
