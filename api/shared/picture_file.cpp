#include "api/shared/picture_file.h"

#include <filesystem>
#include <fstream>

#include "common/ids.h"

namespace diaphane::api {

namespace fs = std::filesystem;

Result<void> write_picture(const std::string& name, std::string_view bytes) {
  const fs::path path(name);
  const auto broken = [] {
    return fail(ErrorCode::kUnavailable,
                "The image can't be saved at the moment. Try again later.");
  };
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) return broken();
  const fs::path temporary = path.parent_path() / (".tmp-" + random_hex(8));
  std::ofstream file(temporary, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) fs::rename(temporary, path, error);
  if (!file || error) {
    fs::remove(temporary, error);
    return broken();
  }
  return {};
}

}  // namespace diaphane::api
