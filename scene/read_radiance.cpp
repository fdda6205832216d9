#include <charconv>
#include <cstring>
#include <span>

#include "scene/panorama_readers.h"

namespace diaphane::scene {
namespace {

/// Consumes a file from its beginning.
class Input {
 public:
  explicit Input(std::string_view rest) : rest_(rest) {}

  std::optional<std::string_view> line() {
    const std::size_t end = rest_.find('\n');
    if (end == std::string_view::npos) return {};
    const std::string_view found = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    return found;
  }
  bool pixel(Rgbe& out) {
    if (!peek(out)) return false;
    rest_.remove_prefix(out.size());
    return true;
  }
  bool peek(Rgbe& out) const {
    if (rest_.size() < out.size()) return false;
    std::memcpy(out.data(), rest_.data(), out.size());
    return true;
  }
  std::optional<std::uint8_t> byte() {
    if (rest_.empty()) return {};
    const auto value = static_cast<std::uint8_t>(rest_.front());
    rest_.remove_prefix(1);
    return value;
  }

 private:
  std::string_view rest_;
};

/// Reads one component of a line that is compressed in runs.
bool read_component(Input& in, std::span<Rgbe> line, std::size_t component) {
  for (std::size_t x = 0; x < line.size();) {
    const auto count = in.byte();
    if (!count || *count == 0) return false;
    const bool is_run = *count > 128;
    const std::size_t length = is_run ? *count - 128U : *count;
    if (length > line.size() - x) return false;
    std::optional<std::uint8_t> value;
    for (std::size_t i = 0; i < length; ++i, ++x) {
      if (i == 0 || !is_run) value = in.byte();
      if (!value) return false;
      line[x][component] = *value;
    }
  }
  return true;
}

/// Reads a line of whole pixels, in which 1 1 1 n repeats the previous pixel n times. Of successive
/// repetitions, each counts 256 times as much as the one before.
bool read_old_line(Input& in, std::span<Rgbe> line) {
  unsigned shift = 0;
  for (std::size_t x = 0; x < line.size();) {
    Rgbe pixel;
    if (!in.pixel(pixel)) return false;
    if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
      line[x++] = pixel;
      shift = 0;
      continue;
    }
    if (x == 0 || shift > 8) return false;
    const std::size_t count = std::size_t{pixel[3]} << shift;
    if (count > line.size() - x) return false;
    std::fill_n(line.begin() + static_cast<std::ptrdiff_t>(x), count, line[x - 1]);
    x += count;
    shift += 8;
  }
  return true;
}

bool read_line(Input& in, std::span<Rgbe> line) {
  Rgbe first;
  if (!in.peek(first)) return false;
  const bool compressed = line.size() >= 8 && first[0] == 2 && first[1] == 2 && first[2] < 128;
  if (!compressed) return read_old_line(in, line);
  (void)in.pixel(first);
  if (std::size_t{first[2]} * 256 + first[3] != line.size()) return false;
  for (std::size_t component = 0; component < 4; ++component) {
    if (!read_component(in, line, component)) return false;
  }
  return true;
}

/// Reads "-Y height +X width", the usual order of pixels.
std::optional<PanoramaFault> read_size(std::string_view text, std::uint32_t& width,
                                       std::uint32_t& height) {
  if (!text.starts_with("-Y ")) return PanoramaFault::kVariant;
  const char* const end = text.data() + text.size();
  const auto down = std::from_chars(text.data() + 3, end, height);
  if (down.ec != std::errc()) return PanoramaFault::kDamaged;
  const std::string_view rest(down.ptr, static_cast<std::size_t>(end - down.ptr));
  if (!rest.starts_with(" +X ")) return PanoramaFault::kVariant;
  const auto across = std::from_chars(down.ptr + 4, end, width);
  if (across.ec != std::errc() || across.ptr != end) return PanoramaFault::kDamaged;
  return fault_of_size(width, height);
}

}  // namespace

tl::expected<EnvironmentPicture, PanoramaFault> read_radiance(std::string_view file) {
  Input in(file);
  auto line = in.line();
  // The header's exposure and colour correction only scale the picture, which is scaled anyway.
  while (line && !line->empty()) {
    if (line->starts_with("FORMAT=") && *line != "FORMAT=32-bit_rle_rgbe") {
      return tl::unexpected(PanoramaFault::kVariant);
    }
    line = in.line();
  }
  if (line) line = in.line();
  if (!line) return tl::unexpected(PanoramaFault::kDamaged);
  std::uint32_t width = 0, height = 0;
  if (const auto fault = read_size(*line, width, height)) return tl::unexpected(*fault);
  PanoramaReduction reduction(width, height);
  std::vector<Rgbe> pixels(width);
  for (std::uint32_t y = 0; y < height; ++y) {
    if (!read_line(in, pixels)) return tl::unexpected(PanoramaFault::kDamaged);
    for (std::uint32_t x = 0; x < width; ++x) {
      const Rgbe& p = pixels[x];
      reduction.add(x, y, radiance_of(p, 0), radiance_of(p, 1), radiance_of(p, 2));
    }
  }
  return reduction.finish();
}

}  // namespace diaphane::scene
