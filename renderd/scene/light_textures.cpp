#include "renderd/scene/light_textures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "common/try.h"
#include "renderd/scene/environment_store.h"
#include "renderd/scene/texture_store.h"

namespace diaphane::render {
namespace {

/// Fraction of the mean of a row or map that is added to each texel's brightness. So every
/// direction can be drawn, and no texel's probability is lost in the rounding of its row's sums.
constexpr double kFloor = 0.01;

double brightness(const Float4& c) {
  return static_cast<double>(c.x) + static_cast<double>(c.y) + static_cast<double>(c.z);
}

/// Replaces each value of a row by (previous + 6 * value + next) / 8, which is the mean over its
/// texel of the linearly interpolated row.
void blur(std::vector<double>& row, double before, double after) {
  for (std::size_t i = 0; i < row.size(); ++i) {
    const double next = i + 1 == row.size() ? after : row[i + 1];
    const double blurred = 0.125 * before + 0.75 * row[i] + 0.125 * next;
    before = row[i];
    row[i] = blurred;
  }
}

/// Stores the cumulative sums of `weights`, with a floor, divided by their total; the last one is
/// 1.
template <typename Store>
void accumulate(const std::vector<double>& weights, const Store& store) {
  double total = 0;
  for (const double w : weights) total += w;
  const auto count = static_cast<double>(weights.size());
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    sum += total > 0 ? (weights[i] / total + kFloor / count) / (1 + kFloor) : 1 / count;
    store(i, i + 1 == weights.size() ? 1.0f : static_cast<float>(std::min(sum, 1.0)));
  }
}

/// Fills in the w of the texels and the rows, from which directions are sampled. The weight of a
/// texel is the mean brightness of the interpolated picture over it.
void add_distribution(std::span<Float4> texels, std::size_t width, std::size_t height,
                      std::vector<float>& rows) {
  std::vector<double> in_row(height), above(width), here(width), below(width), of_texel(width);
  const auto read = [&](std::size_t j, std::vector<double>& row) {
    std::ranges::transform(texels.subspan(width * j, width), row.begin(), brightness);
  };
  read(0, here);
  above = here;
  for (std::size_t j = 0; j < height; ++j) {
    if (j + 1 < height) {
      read(j + 1, below);
    } else {
      below = here;
    }
    for (std::size_t i = 0; i < width; ++i) {
      of_texel[i] = 0.125 * above[i] + 0.75 * here[i] + 0.125 * below[i];
    }
    blur(of_texel, of_texel.back(), of_texel.front());  // the columns wrap around
    in_row[j] = std::accumulate(of_texel.begin(), of_texel.end(), 0.0);
    const double middle =
        std::numbers::pi * (static_cast<double>(j) + 0.5) / static_cast<double>(height);
    in_row[j] *= std::sin(middle);
    accumulate(of_texel, [&](std::size_t i, float sum) { texels[i + width * j].w = sum; });
    std::swap(above, here);
    std::swap(here, below);
  }
  const std::size_t first = rows.size();
  rows.resize(first + height);
  accumulate(in_row, [&](std::size_t j, float sum) { rows[first + j] = sum; });
}

void add_means(std::span<const Float4> texels, std::size_t width, std::size_t height,
               PreparedTextures& out) {
  Double3 plain{}, sky{};
  double weights = 0;
  for (std::size_t j = 0; j < height; ++j) {
    Double3 row{};
    for (std::size_t i = 0; i < width; ++i) {
      const Float4& c = texels[i + width * j];
      row += to_double(Float3{c.x, c.y, c.z});
    }
    const double weight =
        std::sin(std::numbers::pi * (static_cast<double>(j) + 0.5) / static_cast<double>(height));
    plain += row;
    sky += row * weight;
    weights += weight;
  }
  const auto columns = static_cast<double>(width);
  out.means.push_back(plain * (1 / (columns * static_cast<double>(height))));
  out.sky_means.push_back(sky * (1 / (columns * weights)));
}

/// Returns a pixel in linear light.
Float3 pixel_of(const TexturePicture& picture, std::size_t index) {
  if (!picture.rgbe.empty()) {
    const scene::Rgbe& c = picture.rgbe[index];
    return {scene::radiance_of(c, 0), scene::radiance_of(c, 1), scene::radiance_of(c, 2)};
  }
  static const std::array<float, 256>& linear = linear_of_srgb();
  const std::uint8_t* c = picture.rgb.data() + 3 * index;
  return {linear[c[0]], linear[c[1]], linear[c[2]]};
}

/// Fills `texels` with the means in linear light of the pixels that each of them covers.
void reduce(const TexturePicture& picture, TextureSize kept, std::span<Float4> texels) {
  const std::size_t width = picture.size.width, height = picture.size.height;
  for (std::size_t j = 0; j < kept.height; ++j) {
    const std::size_t top = j * height / kept.height, bottom = (j + 1) * height / kept.height;
    for (std::size_t i = 0; i < kept.width; ++i) {
      const std::size_t left = i * width / kept.width, right = (i + 1) * width / kept.width;
      Float3 sum{};
      for (std::size_t y = top; y < bottom; ++y) {
        for (std::size_t x = left; x < right; ++x) sum += pixel_of(picture, x + width * y);
      }
      const Float3 mean = sum * (1 / static_cast<float>((bottom - top) * (right - left)));
      texels[i + kept.width * j] = {mean.x, mean.y, mean.z, 0.0f};
    }
  }
}

/// Appends the texels of a picture. `out` must already have its entry, as the last one, and
/// reserved memory.
void add_picture(const TexturePicture& picture, PreparedTextures& out) {
  const TextureSize kept = kept_size(picture.size);
  const std::size_t width = kept.width, height = kept.height;
  const std::size_t first = out.texels.size();
  out.texels.resize(first + width * height);
  const std::span<Float4> texels = std::span(out.texels).subspan(first);
  reduce(picture, kept, texels);
  add_means(texels, width, height, out);
  add_distribution(texels, width, height, out.rows);
}

void copy_texture(const PreparedTextures& from, std::uint32_t index, PreparedTextures& out) {
  const LightTexture& t = from.textures[index];
  const auto texels = std::span(from.texels)
                          .subspan(t.first_texel, static_cast<std::size_t>(t.width) *
                                                      static_cast<std::size_t>(t.height));
  const auto rows = std::span(from.rows).subspan(t.first_row, static_cast<std::size_t>(t.height));
  out.texels.insert(out.texels.end(), texels.begin(), texels.end());
  out.rows.insert(out.rows.end(), rows.begin(), rows.end());
  out.means.push_back(from.means[index]);
  out.sky_means.push_back(from.sky_means[index]);
}

bool has(const PreparedTextures& textures, const std::string& file) {
  return std::find(textures.files.begin(), textures.files.end(), file) != textures.files.end();
}

/// Returns the files without duplicates.
std::vector<TextureFile> different(const std::vector<TextureFile>& files) {
  std::vector<TextureFile> out;
  for (const TextureFile& f : files) {
    const bool known = std::any_of(out.begin(), out.end(),
                                   [&f](const TextureFile& o) { return *o.file == *f.file; });
    if (!known) out.push_back(f);
  }
  return out;
}

tl::unexpected<Error> named(const std::string& field, const Error& error) {
  return fail(error.code, field + " " + error.message, field);
}

/// Counts the memory that each owner has taken and finds textures that can be shared.
class TextureMemory {
 public:
  using Prepared = std::shared_ptr<const PreparedTextures>;

  void limit(std::size_t all, std::size_t owners) {
    const std::lock_guard lock(mutex_);
    all_ = all;
    owners_ = owners;
  }
  bool take(const std::string& owner, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (taken_ + bytes > all_) return false;
    if (!owner.empty() && by_owner_[owner] + bytes > owners_) return false;
    taken_ += bytes;
    if (!owner.empty()) by_owner_[owner] += bytes;
    return true;
  }
  void give_back(const std::string& owner, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    taken_ -= bytes;
    freed_ += bytes;
    const auto mine = by_owner_.find(owner);
    if (mine != by_owner_.end() && (mine->second -= bytes) == 0) by_owner_.erase(mine);
  }
  Prepared find(const std::vector<TextureFile>& files) {
    std::vector<std::weak_ptr<const PreparedTextures>> known;
    {
      const std::lock_guard lock(mutex_);
      std::erase_if(known_, [](const auto& one) { return one.expired(); });
      known = known_;
    }
    // Runs without the lock, because this thread may become the last owner of an entry and then
    // gives its memory back, which takes the lock.
    for (const auto& one : known) {
      Prepared found = one.lock();
      if (found && same_files(files, *found)) return found;
    }
    return nullptr;
  }
  void add(const Prepared& prepared) {
    const std::lock_guard lock(mutex_);
    known_.push_back(prepared);
  }
  std::size_t taken() const {
    const std::lock_guard lock(mutex_);
    return taken_;
  }
  std::size_t take_freed() {
    const std::lock_guard lock(mutex_);
    return std::exchange(freed_, 0);
  }

  static bool same_files(const std::vector<TextureFile>& files, const PreparedTextures& prepared) {
    return std::equal(files.begin(), files.end(), prepared.files.begin(), prepared.files.end(),
                      [](const TextureFile& a, const std::string& b) { return *a.file == b; });
  }

 private:
  mutable std::mutex mutex_;
  std::size_t all_ = kTextureMemory, owners_ = kOwnersTextureMemory;
  std::size_t taken_ = 0, freed_ = 0;
  std::map<std::string, std::size_t> by_owner_;
  std::vector<std::weak_ptr<const PreparedTextures>> known_;
};

TextureMemory& memory() {
  // Never destroyed, because a renderer's textures may outlive all other static objects.
  static auto* const memory = new TextureMemory;
  return *memory;
}

/// Owns a part of that memory and gives it back when destroyed.
struct Taken {
  std::string owner;
  std::size_t bytes = 0;

  Taken(std::string who, std::size_t size) : owner(std::move(who)), bytes(size) {}
  Taken(const Taken&) = delete;
  Taken& operator=(const Taken&) = delete;
  ~Taken() { memory().give_back(owner, bytes); }
};

std::size_t pixels_of(TextureSize size) { return std::size_t{size.width} * size.height; }

/// Returns the sizes of all files in their order. Fails with kInvalid for the first file with which
/// the total exceeds `most` pixels.
Result<std::vector<TextureSize>> sizes_of(const std::vector<TextureFile>& files, std::size_t most,
                                          const char* too_much) {
  std::size_t total = 0;
  std::vector<TextureSize> sizes;
  for (const TextureFile& f : files) {
    const auto size = f.stored ? stored_size(*f.file) : texture_size(*f.file);
    if (!size) return named(f.field, size.error());
    total += pixels_of(*size);
    if (total > most) return fail(ErrorCode::kInvalid, f.field + too_much, f.field);
    sizes.push_back(*size);
  }
  return sizes;
}

constexpr char kTooMuch[] = " exceeds the limit of 16777216 pixels for all textures of a scene";

std::size_t bytes_of(const std::vector<TextureFile>& files, const std::vector<TextureSize>& sizes) {
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const TextureSize kept = kept_size(sizes[i]);
    bytes += pixels_of(kept) * sizeof(Float4) + kept.height * sizeof(float) + files[i].file->size();
  }
  return bytes;
}

Result<std::unique_ptr<PreparedTextures>> decode(const std::vector<TextureFile>& files,
                                                 const std::vector<TextureSize>& sizes,
                                                 const PreparedTextures* before) {
  auto out = std::make_unique<PreparedTextures>();
  std::size_t total = 0;
  for (const TextureSize& size : sizes) total += pixels_of(kept_size(size));
  out->texels.reserve(total);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const TextureSize kept = kept_size(sizes[i]);
    out->textures.push_back({static_cast<std::uint32_t>(out->texels.size()),
                             static_cast<std::uint32_t>(out->rows.size()),
                             static_cast<std::int32_t>(kept.width),
                             static_cast<std::int32_t>(kept.height)});
    out->files.push_back(*files[i].file);
    if (before && has(*before, *files[i].file)) {
      copy_texture(*before, texture_index(*before, *files[i].file), *out);
      continue;
    }
    const auto picture =
        files[i].stored ? load_stored(*files[i].file) : decode_texture(*files[i].file);
    if (!picture) return named(files[i].field, picture.error());
    // A stored environment can be deleted while it is read.
    if (!(picture->size == sizes[i])) {
      return named(files[i].field, {ErrorCode::kUnavailable, "has just changed", {}});
    }
    add_picture(*picture, *out);
  }
  return out;
}

}  // namespace

TextureSize kept_size(TextureSize size) {
  for (std::uint32_t divisor = 1;; ++divisor) {
    const TextureSize kept{(size.width + divisor - 1) / divisor,
                           (size.height + divisor - 1) / divisor};
    if (pixels_of(kept) <= kKeptTexels) return kept;
  }
}

void limit_texture_memory(std::size_t all, std::size_t owners) { memory().limit(all, owners); }
std::size_t texture_memory() { return memory().taken(); }
std::size_t take_freed_texture_memory() { return memory().take_freed(); }

Result<std::size_t> bytes_of_textures(const std::vector<TextureFile>& files) {
  const auto unique = different(files);
  const auto sizes = sizes_of(unique, kMostTexels, kTooMuch);
  DIAPHANE_TRY(sizes);
  return bytes_of(unique, *sizes);
}

Result<void> check_visitors_textures(const std::vector<TextureFile>& files) {
  const auto sizes = sizes_of(different(files), kMostVisitorTexels,
                              " exceeds the limit of 1048576 pixels for all textures of a scene, "
                              "which applies without an account");
  DIAPHANE_TRY(sizes);
  return {};
}

Result<std::shared_ptr<const PreparedTextures>> prepare_textures_for(
    const std::string& owner, const std::vector<TextureFile>& files,
    const std::shared_ptr<const PreparedTextures>& before) {
  if (files.empty()) return nullptr;
  const std::vector<TextureFile> unique = different(files);
  if (before && TextureMemory::same_files(unique, *before)) return before;
  if (auto known = memory().find(unique)) return known;
  // Sizes are checked first, so that nothing is decoded if the total is too large.
  const auto sizes = sizes_of(unique, kMostTexels, kTooMuch);
  DIAPHANE_TRY(sizes);
  const std::size_t bytes = bytes_of(unique, *sizes);
  if (!memory().take(owner, bytes)) {
    const std::string& field = unique.back().field;
    return fail(ErrorCode::kTooMany,
                field +
                    " does not fit into the memory of this renderer. Use a picture with fewer "
                    "pixels, or try again later.",
                field);
  }
  auto taken = std::make_shared<const Taken>(owner, bytes);
  auto decoded = decode(unique, *sizes, before.get());
  DIAPHANE_TRY(decoded);
  // The deleter gives the memory back explicitly, because weak pointers keep the deleter itself
  // alive after the textures are gone.
  std::shared_ptr<const PreparedTextures> prepared(
      decoded->release(), [taken](const PreparedTextures* textures) mutable {
        delete textures;
        taken.reset();
      });
  memory().add(prepared);
  return prepared;
}

Result<std::shared_ptr<const PreparedTextures>> prepare_textures(
    const std::vector<TextureFile>& files, const std::shared_ptr<const PreparedTextures>& before) {
  return prepare_textures_for({}, files, before);
}

std::uint32_t texture_index(const PreparedTextures& textures, const std::string& file) {
  const auto at = std::find(textures.files.begin(), textures.files.end(), file);
  return static_cast<std::uint32_t>(at - textures.files.begin());
}

}  // namespace diaphane::render
