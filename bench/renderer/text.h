#pragma once

#include <string>

#include "common/result.h"

// Text that benches read and write.

namespace diaphane::render::bench {

/// Appends at most 319 characters to `to`.
[[gnu::format(printf, 2, 3)]] void print(std::string& to, const char* form, ...);

/// Reads a file. Fails with kNotFound and `field` as the field.
Result<std::string> read_text(const std::string& path, const std::string& field = {});
/// Writes a file, or nothing if the path is empty. Prints to standard error and returns false on
/// failure.
bool written(const std::string& path, const std::string& text);

}  // namespace diaphane::render::bench
