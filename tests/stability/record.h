// What the stability suite finds: one line per case, a test and a row of the page at once.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace rro::test {

/// Fails where `worst` is above `bound` or no number. Said again about the same case, the worst counts.
///
/// family   tag of the test's file; the page has one table for each
/// law      what must hold, and whose measure `bound` and `worst` are; `bound` 0: to the last bit
void record(const std::string& family, const std::string& what, const std::string& law, double bound, double worst);

/// The largest of several deviations; what is no number counts as infinite.
class Worst {
  public:
    void add(double deviation) {
        value_ = std::isnan(deviation) ? std::numeric_limits<double>::infinity() : std::max(value_, deviation);
    }
    /// |value - expected| over |expected|.
    void add_relative(double value, double expected) {
        add(value == expected ? 0.0 : std::abs(value - expected) / std::abs(expected));
    }
    double value() const { return value_; }

  private:
    double value_ = 0;
};

}  // namespace rro::test
