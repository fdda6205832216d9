// diaphane-still-bench FIRST.ppm ... LAST.ppm measures the lossless size of the last of several
// pictures of a converging scene: with each codec in tiles, and with the method of the thesis
// (8.1), which sends differences to the viewer's picture as JPEG and then the residual as PNG.
// Prints Google Benchmark's JSON, with the processor time of each and its bytes.
#include <benchmark/benchmark.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <vector>

#include "renderd/encode/h264_encoder.h"
#include "renderd/encode/tile_codecs.h"
#include "renderd/encode/tiles.h"

namespace {

using namespace diaphane::render;
namespace v1 = diaphane::v1;

constexpr int kRepeats = 5;

PictureRgb8 read_ppm(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string magic;
  int most = 0;
  PictureRgb8 picture;
  in >> magic >> picture.size.width >> picture.size.height >> most;
  in.get();
  picture.pixels.resize(std::size_t{3} * picture.size.width * picture.size.height);
  in.read(reinterpret_cast<char*>(picture.pixels.data()),
          static_cast<std::streamsize>(picture.pixels.size()));
  if (!in || magic != "P6" || most != 255) {
    std::cerr << path << " is not an 8-bit PPM file (P6)\n";
    std::exit(65);
  }
  return picture;
}

/// Measures `code`, which returns the number of bytes that it made. Runs once per repetition,
/// because an encoder's next frame depends on the ones before.
void row(const std::string& name, const std::function<std::size_t()>& code) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [code](benchmark::State& state) {
                                 std::size_t bytes = 0;
                                 for (auto _ : state) bytes = code();
                                 state.counters["bytes"] = static_cast<double>(bytes);
                               })
      ->Iterations(1)
      ->Repetitions(kRepeats)
      ->ReportAggregatesOnly()
      ->Unit(benchmark::kMillisecond);
}

using Coder = diaphane::Result<std::string> (*)(const std::string&, Canvas, int);

std::size_t code_tiles(const PictureRgb8& picture, Coder coder, int level) {
  std::size_t bytes = 0;
  for (const Tile& tile : plan_tiles(picture.size)) {
    std::string pixels;
    for (std::uint32_t y = tile.y; y < tile.y + tile.height; ++y) {
      const auto* from =
          picture.pixels.data() + std::size_t{3} * (std::size_t{y} * picture.size.width + tile.x);
      pixels.append(reinterpret_cast<const char*>(from), std::size_t{3} * tile.width);
    }
    bytes += coder(pixels, {tile.width, tile.height}, level)->size();
  }
  return bytes;
}

struct Jpeg {
  std::size_t bytes = 0;
  PictureRgb8 shown;
};

Jpeg through_jpeg(const PictureRgb8& picture, int quality) {
  Jpeg out;
  out.shown = picture;
  const int width = static_cast<int>(picture.size.width);
  const int height = static_cast<int>(picture.size.height);
  unsigned char* data = nullptr;
  unsigned long bytes = 0;
  const tjhandle coder = tjInitCompress();
  tjCompress2(coder, picture.pixels.data(), width, 0, height, TJPF_RGB, &data, &bytes, TJSAMP_444,
              quality, TJFLAG_ACCURATEDCT);
  const tjhandle decoder = tjInitDecompress();
  tjDecompress2(decoder, data, bytes, out.shown.pixels.data(), width, 0, height, TJPF_RGB,
                TJFLAG_ACCURATEDCT);
  tjFree(data);
  tjDestroy(coder);
  tjDestroy(decoder);
  out.bytes = bytes;
  return out;
}

/// Returns a - b + offset per byte, clamped to 0 to 255 or modulo 256.
PictureRgb8 difference(const PictureRgb8& a, const PictureRgb8& b, int offset, bool cut) {
  PictureRgb8 out = a;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const int value = int(a.pixels[i]) - int(b.pixels[i]) + offset;
    out.pixels[i] = static_cast<std::uint8_t>(cut ? std::clamp(value, 0, 255) : value);
  }
  return out;
}

/// Encodes each picture as its difference from what the viewer has. Returns the bytes and the
/// viewer's final picture.
Jpeg difference_chain(const std::vector<PictureRgb8>& pictures, int quality) {
  Jpeg viewer = through_jpeg(pictures.front(), quality);
  for (std::size_t i = 1; i < pictures.size(); ++i) {
    const Jpeg next = through_jpeg(difference(pictures[i], viewer.shown, 128, true), quality);
    viewer.bytes += next.bytes;
    for (std::size_t j = 0; j < next.shown.pixels.size(); ++j) {
      const int value = int(viewer.shown.pixels[j]) + int(next.shown.pixels[j]) - 128;
      viewer.shown.pixels[j] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
    }
  }
  return viewer;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: diaphane-still-bench FIRST.ppm ... LAST.ppm\n";
    return 64;
  }
  std::vector<PictureRgb8> pictures;
  for (int i = 1; i < argc; ++i) pictures.push_back(read_ppm(argv[i]));
  const PictureRgb8& last = pictures.back();

  row("copy", [last] { return PictureRgb8(last).pixels.size(); });
  for (const int level : {1, 3, 6}) {
    row("png-" + std::to_string(level),
        [last, level] { return code_tiles(last, encode_png, level); });
  }
  for (const int level : {0, 1, 2, 3}) {
    row("webp-" + std::to_string(level),
        [last, level] { return code_tiles(last, encode_webp, level); });
  }
  for (const int quality : {50, 80, 95}) {
    const std::string q = std::to_string(quality);
    row("frames-jpeg-" + q, [pictures, quality] {
      std::size_t bytes = 0;
      for (const PictureRgb8& picture : pictures) bytes += through_jpeg(picture, quality).bytes;
      return bytes;
    });
    row("differences-jpeg-" + q,
        [pictures, quality] { return difference_chain(pictures, quality).bytes; });
    // The residuals of the last picture after its own JPEG frame and after the chain.
    const PictureRgb8 after_frame = difference(last, through_jpeg(last, quality).shown, 128, false);
    const PictureRgb8 after_chain =
        difference(last, difference_chain(pictures, quality).shown, 128, false);
    row("residual-png-after-frame-" + q,
        [after_frame] { return code_tiles(after_frame, encode_png, 3); });
    row("residual-png-after-chain-" + q,
        [after_chain] { return code_tiles(after_chain, encode_png, 3); });
    row("residual-webp-after-chain-" + q,
        [after_chain] { return code_tiles(after_chain, encode_webp, 1); });
  }
  for (const v1::Codec codec : {v1::H264, v1::JPEG, v1::MPEG1}) {
    for (const Quality quality : {Quality::kMoving, Quality::kSettled}) {
      const std::shared_ptr<Encoder> encoder = make_encoder(codec).value();
      for (const bool keys : {true, false}) {
        row(v1::Codec_Name(codec) + (quality == Quality::kMoving ? "-moving" : "-settled") +
                (keys ? "-key" : "-next"),
            [encoder, last, quality, keys] {
              return encoder->encode(last, {quality, keys, 0})->data.size();
            });
      }
    }
  }
  benchmark::JSONReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  return 0;
}
