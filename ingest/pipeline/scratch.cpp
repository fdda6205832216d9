#include "ingest/pipeline/scratch.h"

#include <unistd.h>

#include <filesystem>

namespace diaphane::ingest {

namespace fs = std::filesystem;

std::size_t sweep_scratch(const std::string& directory) {
  std::size_t removed = 0;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    if (!entry.path().filename().string().starts_with("voxels-")) continue;
    std::error_code ignored;
    if (fs::remove(entry.path(), ignored)) ++removed;
  }
  return removed;
}

bool can_write(const std::string& directory) { return access(directory.c_str(), W_OK | X_OK) == 0; }

}  // namespace diaphane::ingest
