#include "bench/renderer/reference.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "common/try.h"
#include "renderd/math/random.h"
#include "renderd/scene/presets.h"

namespace diaphane::render::bench {
namespace {

/// Differs from the small seeds of the measured pictures.
constexpr std::uint64_t kSeed = 0x7265'6665'7265'6e63ULL;
// Magic number of the file. Its last digit is the version of the format.
constexpr std::uint64_t kMagic = 0x3120'6665'7220'6a64ULL;
constexpr Method kPlainest{Walk::kTracking, false, Mis::kBoth};

std::uint64_t hash(std::uint64_t h, const void* data, std::size_t bytes) {
  const auto* from = static_cast<const unsigned char*>(data);
  for (; bytes >= 8; bytes -= 8, from += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, from, 8);
    h = mix64(h * 3 + word);
  }
  for (; bytes > 0; --bytes, ++from) h = mix64(h * 3 + *from);
  return h;
}

std::filesystem::path file_of(const Subject& subject, const std::string& folder) {
  const std::string scene = scene_to_json(subject.scene);
  std::uint64_t key = hash(subject.voxels_hash, scene.data(), scene.size());
  key = hash(key, &subject.canvas, sizeof subject.canvas);
  std::ostringstream name;
  name << "reference-" << std::hex << key << ".bin";
  return std::filesystem::path(folder) / name.str();
}

struct FileHead {
  std::uint64_t magic;
  Canvas canvas;
  double samples, error, seconds;
};

bool read_cached(const std::filesystem::path& path, Reference& reference) {
  std::ifstream file(path, std::ios::binary);
  FileHead head{};
  if (!file.read(reinterpret_cast<char*>(&head), sizeof head)) return false;
  if (head.magic != kMagic || head.canvas != reference.canvas) return false;
  const std::size_t pixels = std::size_t{head.canvas.width} * head.canvas.height;
  std::vector<double> mean(3 * pixels);
  std::vector<std::uint8_t> contents(pixels);
  file.read(reinterpret_cast<char*>(mean.data()), std::ssize(mean) * 8);
  file.read(reinterpret_cast<char*>(contents.data()), std::ssize(contents));
  if (!file) return false;
  reference.mean = std::move(mean);
  reference.contents = std::move(contents);
  reference.samples = head.samples;
  reference.error = head.error;
  reference.seconds = head.seconds;
  return true;
}

/// Caches a reference. Ignores errors, because a missing cache costs only time in the next run.
void write_cached(const std::filesystem::path& path, const Reference& reference) {
  std::error_code ignored;
  std::filesystem::create_directories(path.parent_path(), ignored);
  const std::filesystem::path temporary = path.string() + ".tmp";
  {
    std::ofstream file(temporary, std::ios::binary);
    const FileHead head{kMagic, reference.canvas, reference.samples, reference.error,
                        reference.seconds};
    file.write(reinterpret_cast<const char*>(&head), sizeof head);
    file.write(reinterpret_cast<const char*>(reference.mean.data()),
               std::ssize(reference.mean) * 8);
    file.write(reinterpret_cast<const char*>(reference.contents.data()),
               std::ssize(reference.contents));
    if (!file.flush()) return;
  }
  std::filesystem::rename(temporary, path, ignored);
}

/// Merges pictures with disjoint samples, with weights by count and errors in quadrature.
void merge(Reference& into, const PictureRgbF& picture, const std::vector<std::uint8_t>& contents,
           const Progress& progress) {
  const double added = static_cast<double>(progress.samples);
  const double total = into.samples + added;
  const double old_share = into.samples / total, new_share = added / total;
  into.mean.resize(picture.pixels.size(), 0.0);
  into.contents.resize(contents.size(), 0);
  for (std::size_t i = 0; i < into.mean.size(); ++i) {
    into.mean[i] = into.mean[i] * old_share + static_cast<double>(picture.pixels[i]) * new_share;
  }
  for (std::size_t i = 0; i < contents.size(); ++i) into.contents[i] |= contents[i];
  into.error = std::hypot(into.error * old_share, progress.error * new_share);
  into.samples = total;
  into.seconds += progress.seconds;
}

/// Returns the merged error after `progress` is added.
double merged_error(const Reference& old, const Progress& progress) {
  const double added = static_cast<double>(progress.samples);
  return std::hypot(old.error * old.samples, progress.error * added) / (old.samples + added);
}

}  // namespace

std::uint64_t hash_of(const volume::Volume& v) {
  std::uint64_t h = hash(1, v.voxels.data(), v.voxels.size() * sizeof v.voxels[0]);
  h = hash(h, v.header.size.data(), sizeof v.header.size);
  h = hash(h, v.header.spacing.data(), sizeof v.header.spacing);
  return hash(h, v.header.direction.data(), sizeof v.header.direction);
}

Result<Reference> reference_of(const Subject& subject, const ReferenceOptions& options) {
  Reference reference;
  reference.canvas = subject.canvas;
  const bool cached = !options.cache.empty();
  const std::filesystem::path path = cached ? file_of(subject, options.cache) : "";
  const bool found = cached && !options.fresh && read_cached(path, reference);
  if (!found || reference.error > options.error) {
    auto renderer = subject.engine->renderer(
        subject.volume, kSeed, static_cast<std::uint64_t>(reference.samples), kPlainest);
    DIAPHANE_TRY(renderer);
    DIAPHANE_TRY((*renderer)->set_scene(subject.scene, subject.canvas));
    // Pieces grow, because the error estimate between them takes time too.
    std::uint32_t piece = 16;
    Progress progress;
    do {
      auto batch = (*renderer)->render(piece, [] { return false; });
      DIAPHANE_TRY(batch);
      piece = std::min(piece * 2, 4096u);
      progress = (*renderer)->progress();
      if (options.progress) {
        Reference so_far;
        so_far.samples = reference.samples + static_cast<double>(progress.samples);
        so_far.error = merged_error(reference, progress);
        options.progress(so_far);
      }
    } while (merged_error(reference, progress) > options.error &&
             progress.seconds < options.seconds);
    PictureRgbF picture;
    std::vector<std::uint8_t> contents;
    DIAPHANE_TRY((*renderer)->radiance(picture));
    DIAPHANE_TRY((*renderer)->contents(contents));
    merge(reference, picture, contents, progress);
    if (cached) write_cached(path, reference);
  }
  reference.filmic = subject.scene.display().curve() == diaphane::v1::Display::FILMIC;
  reference.white = white_of(reference.mean, reference.contents);
  return reference;
}

}  // namespace diaphane::render::bench
