#include "ingest/build/read_image.h"

#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <new>
#include <vector>

#include "common/try.h"
#include "ingest/build/image_volume.h"
#include "ingest/build/meta_image.h"
#include "ingest/build/nifti.h"
#include "ingest/build/nrrd.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

std::string lower_name(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

bool is_meta(const std::string& name) { return name.ends_with(".mha") || name.ends_with(".mhd"); }
bool is_nifti_name(const std::string& name) {
  return name.ends_with(".nii") || name.ends_with(".nii.gz");
}
bool is_nrrd(const std::string& name) { return name.ends_with(".nrrd"); }

/// Returns the contents of a file, decompressed if it is compressed with gzip.
Result<std::vector<std::byte>> unpacked_file(const std::string& path) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(path.c_str(), "rb"), gzclose);
  if (in == nullptr) return fail(ErrorCode::kNotFound, "the file cannot be read");
  constexpr std::size_t kPiece = 1 << 26;
  std::vector<std::byte> bytes;
  try {
    for (std::size_t size = 0;; size = bytes.size()) {
      bytes.resize(size + kPiece);
      const int got = gzread(in.get(), bytes.data() + size, kPiece);
      if (got < 0) return damaged_image();
      bytes.resize(size + static_cast<std::size_t>(got));
      if (got == 0) return bytes;
      if (bytes.size() > 8 * volume::kMaxVoxels)
        return fail(ErrorCode::kTooLarge, "the image is too large");
    }
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the image does not fit in memory");
  }
}

Result<volume::Volume> read_nifti(const std::string& path) {
  const auto file = unpacked_file(path);
  DIAPHANE_TRY(file);
  const auto header = read_nifti_header(*file);
  DIAPHANE_TRY(header);
  return read_nifti_voxels(*file, *header);
}

Result<volume::Volume> to_volume(const Result<Image>& image) {
  DIAPHANE_TRY(image);
  return to_volume(image->voxels, image->header);
}

}  // namespace

bool is_image_name(const std::string& path) {
  const std::string name = lower_name(path);
  return is_meta(name) || is_nifti_name(name) || is_nrrd(name);
}

Result<volume::Volume> read_image(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return fail(ErrorCode::kNotFound, "the file does not exist");
  }
  const std::string name = lower_name(path);
  if (is_meta(name)) return to_volume(read_meta_image(path));
  if (is_nifti_name(name)) return read_nifti(path);
  if (is_nrrd(name)) return to_volume(read_nrrd(path));
  return fail(ErrorCode::kUnsupported,
              "unsupported file type; use .mha, .mhd, .nii, .nii.gz or .nrrd");
}

}  // namespace diaphane::ingest
