#include "api/environments/panorama_child.h"

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>

#include "common/fd.h"
#include "common/log.h"
#include "common/sandbox/sandbox.h"
#include "common/sandbox/supervisor.h"
#include "common/try.h"
#include "scene/environment_import.h"

namespace diaphane::api {
namespace {

using scene::PanoramaFault;

/// Maximum address space of the child, in bytes. Decoding the largest picture takes 150 MB.
constexpr std::uint64_t kMostImportMemory = std::uint64_t{768} << 20;
constexpr std::uint32_t kMostImportSeconds = 10;
constexpr int kExitNoSandbox = 70, kExitDisk = 74;
constexpr std::uint32_t kPreviewWidth = 32, kPreviewHeight = 16;

/// Returns an in-memory file with these bytes, positioned at its start.
Fd memory_file(std::string_view bytes) {
  Fd file(memfd_create("panorama", MFD_CLOEXEC));
  const bool ok = file && write_all(file.get(), bytes.data(), bytes.size()) &&
                  lseek(file.get(), 0, SEEK_SET) == 0;
  return ok ? std::move(file) : Fd(-1);
}

/// Reads at most `most` + 1 bytes from the child's input, so that the caller notices a larger file.
std::string read_input(std::size_t most) {
  std::string bytes(most + 1, '\0');
  std::size_t read_so_far = 0;
  while (read_so_far < bytes.size()) {
    const ssize_t got = ::read(kChildInput, bytes.data() + read_so_far, bytes.size() - read_so_far);
    if (got <= 0) break;
    read_so_far += static_cast<std::size_t>(got);
  }
  bytes.resize(read_so_far);
  return bytes;
}

int report(PanoramaFault fault) {
  const std::string word = word_of(fault);
  return write_all(kChildReport, word.data(), word.size()) ? 0 : kExitDisk;
}

Error refusal(PanoramaFault fault) {
  return {ErrorCode::kInvalid, sentence_of(fault), word_of(fault)};
}

/// Parses the child's report. The child is not trusted, so any unknown word means kDamaged.
PanoramaFault fault_in(const std::string& word) {
  for (const auto fault :
       {PanoramaFault::kTooLarge, PanoramaFault::kFormat, PanoramaFault::kVariant,
        PanoramaFault::kTooManyPixels, PanoramaFault::kShape, PanoramaFault::kBlack}) {
    if (word == word_of(fault)) return fault;
  }
  return PanoramaFault::kDamaged;
}

/// Returns the child's output, or kInvalid if it is not a picture in its stored form.
Result<std::string> picture_in(int output) {
  struct stat info {};
  if (fstat(output, &info) != 0 || lseek(output, 0, SEEK_SET) != 0 ||
      info.st_size > static_cast<off_t>(scene::kMostEnvironmentBytes)) {
    return tl::unexpected(refusal(PanoramaFault::kDamaged));
  }
  std::string picture(static_cast<std::size_t>(info.st_size), '\0');
  if (!read_all(output, picture.data(), picture.size()) || !scene::read_environment(picture)) {
    return tl::unexpected(refusal(PanoramaFault::kDamaged));
  }
  return picture;
}

}  // namespace

int run_panorama_child() {
  const SandboxLimits limits{.memory_bytes = kMostImportMemory,
                             .output_bytes = scene::kMostEnvironmentBytes,
                             .cpu_seconds = kMostImportSeconds,
                             .input = kChildInput,
                             .last_output = kChildReport};
  if (!enter_sandbox(limits)) return kExitNoSandbox;
  try {
    const auto imported = scene::import_panorama(read_input(scene::kMostPanoramaBytes));
    if (!imported) return report(imported.error());
    const std::string picture = scene::write_environment(*imported);
    return write_all(kChildOutput, picture.data(), picture.size()) ? 0 : kExitDisk;
  } catch (const std::bad_alloc&) {
    return report(PanoramaFault::kDamaged);
  }
}

Result<ImportedPanorama> SandboxedImporter::import(const std::string& file) {
  const auto unavailable = [] {
    return fail(ErrorCode::kUnavailable, "The file can't be read at the moment. Try again later.");
  };
  const Fd input = memory_file(file), output = memory_file({});
  if (!input || !output) return unavailable();
  const auto end = run_child({program_,
                              {kPanoramaWord},
                              input.get(),
                              output.get(),
                              std::chrono::seconds(kMostImportSeconds)},
                             [] { return true; });
  if (!end || end->how == ChildEnd::How::kDelayed) return unavailable();
  if (end->how != ChildEnd::How::kExited || end->exit_code != 0) {
    log::warning("a panorama could not be read",
                 {{"exit_code", end->exit_code}, {"signal", end->signal}});
    // Only a bad file makes the child crash or take too long. Other exits are the machine's fault.
    if (end->how == ChildEnd::How::kExited) return unavailable();
    return tl::unexpected(refusal(PanoramaFault::kDamaged));
  }
  if (!end->report.empty()) return tl::unexpected(refusal(fault_in(end->report)));
  auto picture = picture_in(output.get());
  DIAPHANE_TRY(picture);
  std::string preview = preview_of(*picture);
  return ImportedPanorama{*std::move(picture), std::move(preview)};
}

std::string preview_of(const std::string& picture) {
  const auto read = scene::read_environment(picture);
  if (!read) return {};
  std::string preview;
  for (std::uint32_t y = 0; y < kPreviewHeight; ++y) {
    for (std::uint32_t x = 0; x < kPreviewWidth; ++x) {
      const std::uint32_t left = x * read->width / kPreviewWidth;
      const std::uint32_t right = std::max(left + 1, (x + 1) * read->width / kPreviewWidth);
      const std::uint32_t top = y * read->height / kPreviewHeight;
      const std::uint32_t bottom = std::max(top + 1, (y + 1) * read->height / kPreviewHeight);
      std::array<double, 3> sum{};
      for (std::uint32_t j = top; j < bottom; ++j) {
        for (std::uint32_t i = left; i < right; ++i) {
          const scene::Rgbe& pixel = read->pixels[i + std::size_t{j} * read->width];
          for (std::size_t c = 0; c < 3; ++c) {
            sum[c] += static_cast<double>(scene::radiance_of(pixel, c));
          }
        }
      }
      for (const double total : sum) {
        const double mean = total / ((right - left) * (bottom - top));
        // Maps a mean radiance of 1 to a middle grey.
        const auto level = std::lround(255 * std::pow(mean / (mean + 3), 1 / 2.2));
        constexpr char kHex[] = "0123456789abcdef";
        preview += {kHex[level >> 4], kHex[level & 15]};
      }
    }
  }
  return preview;
}

}  // namespace diaphane::api
