// Where a measurement was made: times mean nothing without it.
#pragma once

#include <cstdint>
#include <string>

namespace rro {

/// This machine, as far as times depend on it.
struct MachineFacts {
    std::string processor;        // as the system names it
    unsigned cores = 0;           // that this process may use
    unsigned threads = 0;         // that it does use
    std::uint64_t memory = 0;     // bytes
    std::string system;           // kernel and its version
    double load = 0;              // jobs that ran on the average of the last minute: other work makes times longer
    std::string program;          // rro-solve and its version
    std::string compiler;         // that built it, and whether assertions are on
};

/// As it is now.
MachineFacts machine_facts();

/// SHA-256 of the running program's file, or empty: times of another build are not this one's.
std::string program_digest();

}  // namespace rro
