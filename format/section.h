// The sections of an archive, by name and as sets.
#pragma once

#include <cstdint>

namespace rro {

/// In the order in which they are verified: each needs only sections before it (layout::kSections says which).
enum class Section : std::uint32_t {
    Meta, Mesh, Materials, Patches, Clusters, Area, Visibility, Errors, Hbv, Source, Hit, Atlas, SelfLinks
};
/// How many kinds there are.
inline constexpr std::uint32_t kSectionKinds = 13;

/// A set of sections: `Section::Area | Section::Visibility`.
class SectionSet {
  public:
    constexpr SectionSet() = default;
    constexpr SectionSet(Section section) : bits_(1u << static_cast<std::uint32_t>(section)) {}

    constexpr bool has(Section section) const { return (bits_ & SectionSet(section).bits_) != 0; }

    static constexpr SectionSet all() { return SectionSet((1u << kSectionKinds) - 1); }

  private:
    friend constexpr SectionSet operator|(SectionSet a, SectionSet b);
    constexpr explicit SectionSet(std::uint32_t bits) : bits_(bits) {}
    std::uint32_t bits_ = 0;
};
/// What is in either set.
constexpr SectionSet operator|(SectionSet a, SectionSet b) { return SectionSet(a.bits_ | b.bits_); }
constexpr SectionSet operator|(Section a, SectionSet b) { return SectionSet(a) | b; }

/// What light in a scene is computed from, without the tables.
inline constexpr SectionSet kGeometry = Section::Mesh | Section::Materials | Section::Patches | Section::Clusters;
/// The tables per direction, and transport inside the object.
inline constexpr SectionSet kTables =
    Section::Area | Section::Visibility | Section::Errors | Section::SelfLinks;

}  // namespace rro
