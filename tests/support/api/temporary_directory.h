#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "common/ids.h"

namespace diaphane::api {

/// An empty directory of one test, which is deleted with its files.
class TemporaryDirectory {
 public:
  TemporaryDirectory() { std::filesystem::create_directories(path_); }
  ~TemporaryDirectory() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  std::string path() const { return path_.string(); }
  /// Writes a file and the directories above it.
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << text;
  }
  /// Returns an empty string if there is no such file.
  std::string read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(path_ / name, std::ios::binary).rdbuf();
    return text.str();
  }
  bool has(const std::string& name) const { return std::filesystem::exists(path_ / name); }

 private:
  const std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("diaphane-" + random_hex(8));
};

}  // namespace diaphane::api
