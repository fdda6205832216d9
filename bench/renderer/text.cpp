#include "bench/renderer/text.h"

#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

namespace diaphane::render::bench {

void print(std::string& to, const char* form, ...) {
  char text[320];
  va_list arguments;
  va_start(arguments, form);
  std::vsnprintf(text, sizeof text, form, arguments);
  va_end(arguments);
  to += text;
}

Result<std::string> read_text(const std::string& path, const std::string& field) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  if (!file) return fail(ErrorCode::kNotFound, "cannot read " + path, field);
  return text.str();
}

bool written(const std::string& path, const std::string& text) {
  if (path.empty()) return true;
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) std::cerr << "diaphane-renderd-bench: cannot write " << path << '\n';
  return static_cast<bool>(file);
}

}  // namespace diaphane::render::bench
