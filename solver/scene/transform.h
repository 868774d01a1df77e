// Where an instance stands: the parts of a transform, and whether a transform can be worked with.
#pragma once

#include <string>

#include "format/geometry.h"

namespace rro {

/// p' = T R S p: scale, then rotate about the axis, then translate.
struct TransformParts {
    Vec3 translate{0, 0, 0};
    Vec3 axis{0, 1, 0};  // not 0; need not be unit
    double degrees = 0;  // right-handed about the axis
    Vec3 scale{1, 1, 1};
};

/// T R S as one map. Quarter turns are exact.
Affine3 compose(const TransformParts& parts);

/// Ratio of the largest to the smallest singular value; infinity where the matrix is singular.
/// source   one-sided Jacobi rotations [Demmel, Veselic 1992]: small singular values come out to full relative accuracy
double condition_number(const Mat3& m);

/// Why instances cannot be placed by this transform (not finite, singular, condition number above 1e9), or empty.
std::string transform_fault(const Affine3& to_world);

}  // namespace rro
