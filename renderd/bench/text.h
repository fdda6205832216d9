#pragma once

#include <string>

#include "common/result.h"

// Text that benches read and write.

namespace diaphane::render::bench {

/// Appends to `to`, 319 characters at most.
[[gnu::format(printf, 2, 3)]] void print(std::string& to, const char* form, ...);

/// kNotFound names `field`.
Result<std::string> read_text(const std::string& path, const std::string& field = {});
/// Nothing without a path; says on standard error when it cannot.
bool written(const std::string& path, const std::string& text);

}  // namespace diaphane::render::bench
