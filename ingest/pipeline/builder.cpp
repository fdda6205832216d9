#include "ingest/pipeline/builder.h"

#include <fcntl.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <iterator>
#include <new>
#include <span>

#include "common/fd.h"
#include "common/sandbox/supervisor.h"
#include "common/try.h"
#include "ingest/pipeline/align_child.h"
#include "ingest/pipeline/child.h"
#include "ingest/pipeline/cut_child.h"
#include "ingest/pipeline/export_child.h"
#include "ingest/pipeline/export_jobs.h"
#include "ingest/pipeline/label_child.h"
#include "volume/frame_of_reference.h"
#include "volume/header.h"
#include "volume/labels.h"

namespace diaphane::ingest {
namespace {

constexpr std::uint64_t kMb = std::uint64_t{1} << 20;

/// Opens a file without a name, so that nothing remains of it however this process ends.
int unnamed_file(const std::string& directory) {
  const int fd = open(directory.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  const bool unknown = errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL;
  if (fd >= 0 || !unknown) return fd;
  // The file system does not support unnamed files.
  std::string name = directory + "/voxels-XXXXXX";
  const int named = mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) unlink(name.c_str());
  return named;
}

tl::unexpected<Error> no_room() { return fail(ErrorCode::kTooLarge, "the disk is full"); }

Verdict unsafe() { return refused("unreadable", "This upload could not be read safely."); }

Verdict verdict_of(const ChildEnd& end) {
  switch (end.how) {
    case ChildEnd::How::kExited:
      if (end.exit_code == 0) {
        auto verdict = read_report(end.report);
        if (verdict) return std::move(*verdict);
      }
      return unsafe();
    case ChildEnd::How::kTimedOut:
      return refused("too_slow", "This upload took too long to process.");
    case ChildEnd::How::kCrashed:
    case ChildEnd::How::kDelayed:
    case ChildEnd::How::kStopped:
      break;
  }
  return unsafe();
}

/// Reads the voxels and labels that the child wrote. The child may lie in the header, so size and
/// value range are checked and measured on the actual voxels, and the labels are checked.
Result<void> take_volume(int fd, std::uint64_t most_voxels, Build& build) {
  build.volume.header = std::move(build.verdict.header);
  const std::uint64_t count = build.volume.header.total_voxel_count();
  struct stat info {};
  if (fstat(fd, &info) != 0) return fail(ErrorCode::kInternal, "cannot read the voxels back");
  const std::uint64_t bytes = count * sizeof(std::int16_t);
  const auto written = static_cast<std::uint64_t>(info.st_size);
  if (count > most_voxels || written < bytes ||
      written - bytes > volume::most_label_bytes(build.volume.header)) {
    build.verdict = unsafe();
    return {};
  }
  std::string& labels = build.volume.labels;
  try {
    build.volume.voxels.resize(count);
    labels.resize(written - bytes);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "not enough memory for the volume");
  }
  if (!read_all_at(fd, 0, build.volume.voxels.data(), bytes) ||
      !read_all_at(fd, bytes, labels.data(), labels.size())) {
    return fail(ErrorCode::kInternal, "cannot read the voxels back");
  }
  if (!volume::check_labels(labels, build.volume.header.size)) {
    build.verdict = unsafe();
    return {};
  }
  volume::measure(build.volume, build.verdict.filler);
  std::string& frame = build.volume.header.frame_of_reference;
  build.frame = volume::disguised_uid(frame);
  frame = volume::hidden_frame_of_reference(frame).value_or("");
  return {};
}

std::function<Result<void>(int, Build&)> take_volume_of(const SandboxBuilder::Options& options) {
  return [most = options.quota_mb * kMb / 2](int output, Build& build) {
    return take_volume(output, most, build);
  };
}

/// Reads and checks the label set that the child wrote.
Result<void> take_labels(int fd, const volume::Header& scan, Build& build) {
  struct stat info {};
  if (fstat(fd, &info) != 0) return fail(ErrorCode::kInternal, "cannot read the labels back");
  const auto written = static_cast<std::uint64_t>(info.st_size);
  if (written > volume::most_label_set_bytes(scan)) {
    build.verdict = unsafe();
    return {};
  }
  try {
    build.labels.resize(written);
    if (!read_all_at(fd, 0, build.labels.data(), build.labels.size())) {
      return fail(ErrorCode::kInternal, "cannot read the labels back");
    }
    auto set = volume::decode_label_set(build.labels, scan.size);
    if (!set) {
      build.verdict = unsafe();
      return {};
    }
    build.volume.label_set = *std::move(set);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "not enough memory for the labels");
  }
  return {};
}

/// Copies the file that the child wrote to a new file at `path`. Sets `build.stopped` if it ends
/// early.
Result<void> copy_export(int fd, const std::string& path, Build& build,
                         const Builder::ShouldContinue& should_continue) {
  const Fd to(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0644));
  if (!to) return fail(ErrorCode::kUnavailable, "the export directory is not writable");
  off_t at = 0;
  for (;;) {
    if (!should_continue()) {
      build.stopped = true;
      return {};
    }
    constexpr std::size_t kPiece = std::size_t{64} << 20;
    const ssize_t sent = sendfile(to.get(), fd, &at, kPiece);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {
      const bool full = errno == ENOSPC || errno == EDQUOT;
      return fail(full ? ErrorCode::kTooLarge : ErrorCode::kUnavailable,
                  full ? "the disk is full" : "cannot write the export");
    }
    if (sent == 0) break;
  }
  build.written = static_cast<std::uint64_t>(at);
  return {};
}

/// Appends the first bytes of a file to `to`. Sets `build.stopped` if it ends early.
Result<void> append(const std::string& path, std::uint64_t bytes, int to, Build& build,
                    const Builder::ShouldContinue& should_continue) {
  const Fd from(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!from) return fail(ErrorCode::kUnavailable, "cannot open the stored volume");
  while (bytes > 0) {
    if (!should_continue()) {
      build.stopped = true;
      return {};
    }
    constexpr std::uint64_t kPiece = std::uint64_t{64} << 20;
    const ssize_t sent = sendfile(to, from.get(), nullptr, std::min(bytes, kPiece));
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0 && (errno == ENOSPC || errno == EDQUOT)) return no_room();
    if (sent < 0) return fail(ErrorCode::kUnavailable, "cannot copy the stored volume");
    if (sent == 0) break;  // the child notices that the scan is damaged
    bytes -= static_cast<std::uint64_t>(sent);
  }
  return {};
}

/// Returns the bytes that may still be written on the disk of `directory` while `reserve` stays
/// free.
std::uint64_t free_bytes(const std::string& directory, std::uint64_t reserve) {
  struct statvfs info {};
  if (statvfs(directory.c_str(), &info) != 0) return 0;
  const std::uint64_t free = std::uint64_t{info.f_bavail} * info.f_frsize;
  return free > reserve ? free - reserve : 0;
}

/// Returns whether the child was ended by SIGKILL, which a fault of its own does not raise.
bool was_killed(const ChildEnd& end) {
  return end.how == ChildEnd::How::kCrashed && end.signal == SIGKILL;
}

/// Returns whether the child's end allows a verdict. Otherwise sets the flag of `build` that says
/// why not, or returns the temporary condition.
Result<bool> gives_verdict(const ChildEnd& end, Build& build) {
  build.stopped = end.how == ChildEnd::How::kStopped;
  build.killed = was_killed(end);
  build.delayed = end.how == ChildEnd::How::kDelayed;
  if (build.stopped || build.killed || build.delayed) return false;
  // The child ended before it read a byte, so the machine ended it, for example for lack of memory
  // at its start.
  if (end.how == ChildEnd::How::kCrashed && end.report.empty()) {
    return fail(ErrorCode::kInternal, "the child ended before it read its input");
  }
  if (end.how != ChildEnd::How::kExited) return true;
  constexpr int kNoProgram = 127;
  switch (end.exit_code) {
    case kChildNoSandbox:
    case kNoProgram:  // no sandbox on this machine, or too little memory to start
      return fail(ErrorCode::kInternal, "cannot start the child process");
    case kChildNoRoom:
      return no_room();
    case kChildDiskFails:
      return fail(ErrorCode::kUnavailable,
                  "the child process cannot read its input or write its output");
    case kChildNoMemory:
      build.no_memory = true;
      return false;
    case kChildTooLarge:
      build.too_large = true;
      return false;
    default:
      return true;
  }
}

}  // namespace

/// Returns the free space of the fuller disk, because the voxels are in the scratch directory until
/// the volume is stored.
std::uint64_t SandboxBuilder::room_bytes() const {
  const std::uint64_t reserve = options_.reserve_mb * kMb;
  return std::min(free_bytes(options_.scratch_dir, reserve),
                  free_bytes(options_.volume_dir, reserve));
}

std::optional<SandboxBuilder::DirectoryId> SandboxBuilder::directory_of(const std::string& path) {
  struct stat info {};
  if (stat(path.substr(0, path.rfind('/')).c_str(), &info) != 0) return std::nullopt;
  return DirectoryId(info.st_dev, info.st_ino);
}

Result<Fd> SandboxBuilder::open_upload(const std::string& path, Build& build) {
  Fd input(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (input) {
    uploads_ = directory_of(path);
    return input;
  }
  if (errno != ENOENT) return fail(ErrorCode::kUnavailable, "cannot open the upload");
  // A directory in which no upload has been found may be a mount point whose disk is missing.
  const auto upload_directory = directory_of(path);
  if (!upload_directory || upload_directory != uploads_) {
    return fail(ErrorCode::kUnavailable, "the upload disk is not mounted");
  }
  build.file_missing = true;
  return input;
}

Result<Build> SandboxBuilder::build(const UploadInput& upload,
                                    const ShouldContinue& should_continue) {
  Build missing;
  const auto opened = open_upload(upload.path, missing);
  DIAPHANE_TRY(opened);
  const Fd& input = *opened;
  if (!input) return missing;
  const std::uint64_t room = room_bytes();
  if (room == 0) return no_room();
  const std::uint64_t light = options_.light_mb > 0 ? options_.light_mb * kMb : BuildBounds::kNone;
  return run(input.get(), kChildWord,
             {std::to_string(upload.quota_left.value_or(BuildBounds::kNone)), std::to_string(room),
              std::to_string(light)},
             take_volume_of(options_), should_continue);
}

Result<Build> SandboxBuilder::cut(const CutInput& order, const ShouldContinue& should_continue) {
  auto header = volume::to_json(order.header);
  DIAPHANE_TRY(header);
  const std::string voxels = order.volume_directory + "/voxels.i16";
  const Fd input(open(voxels.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!input) return fail(ErrorCode::kUnavailable, "cannot open the stored voxels");
  if (const auto plan = volume::plan_cut(order.header, order.region)) {
    const std::uint64_t bytes = std::uint64_t{plan->size[0]} * plan->size[1] * plan->size[2] *
                                order.header.phase_count() * sizeof(std::int16_t);
    if (bytes > room_bytes()) return no_room();
  }
  return run(input.get(), kCutChildWord, {*std::move(header), volume::to_json(order.region)},
             take_volume_of(options_), should_continue);
}

Result<Build> SandboxBuilder::place_labels(const LabelInput& labels,
                                           const ShouldContinue& should_continue) {
  Build missing;
  const auto input = open_upload(labels.path, missing);
  DIAPHANE_TRY(input);
  if (!*input) return missing;
  const std::uint64_t most = volume::most_label_set_bytes(labels.scan);
  // Labels take far less than `most` bytes, so an eighth of a byte per voxel suffices as a check
  // against a full disk.
  if (std::min(most, labels.scan.voxel_count() / 8) > room_bytes()) return no_room();
  auto header = volume::to_json(labels.scan);
  DIAPHANE_TRY(header);
  return run(
      input->get(), kLabelChildWord, {*std::move(header)},
      [&](int output, Build& build) { return take_labels(output, labels.scan, build); },
      should_continue);
}

Result<Build> SandboxBuilder::export_scan(const ExportInput& input,
                                          const ShouldContinue& should_continue) {
  auto header = volume::to_json(input.header);
  DIAPHANE_TRY(header);
  const char* name = "/voxels.i16";
  if (input.order.label)
    name = volume::found_part(*input.order.label) != nullptr ? "/labels" : "/label_set";
  const std::string source = input.volume_directory + name;
  const Fd file(open(source.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!file && errno == ENOENT && input.order.label) {
    Build none;
    none.verdict = refused("nothing_inside", "This scan has no such label.");
    return none;
  }
  if (!file) return fail(ErrorCode::kUnavailable, "cannot open the stored volume");
  const std::uint64_t room =
      std::min(free_bytes(options_.scratch_dir, options_.reserve_mb * kMb),
               free_bytes(input.path.substr(0, input.path.rfind('/')), options_.reserve_mb * kMb));
  if (input.header.total_voxel_count() * sizeof(std::int16_t) > room) return no_room();
  return run(
      file.get(), kExportChildWord, {*std::move(header), to_text(input.order)},
      [&](int output, Build& build) {
        return copy_export(output, input.path, build, should_continue);
      },
      should_continue);
}

Result<Build> SandboxBuilder::align(const AlignInput& input,
                                    const ShouldContinue& should_continue) {
  auto fixed = volume::to_json(input.fixed), moving = volume::to_json(input.moving);
  DIAPHANE_TRY(fixed);
  DIAPHANE_TRY(moving);
  const auto bytes = [](const volume::Header& h) { return h.voxel_count() * sizeof(std::int16_t); };
  if (bytes(input.fixed) + bytes(input.moving) >
      free_bytes(options_.scratch_dir, options_.reserve_mb * kMb)) {
    return no_room();
  }
  // The child can read one descriptor only, so both scans become one file.
  const Fd both(unnamed_file(options_.scratch_dir));
  if (!both) return fail(ErrorCode::kUnavailable, "the scratch directory is not writable");
  Build copied;
  for (const auto& [directory, header] : {std::pair{&input.fixed_directory, &input.fixed},
                                          {&input.moving_directory, &input.moving}}) {
    DIAPHANE_TRY(
        append(*directory + "/voxels.i16", bytes(*header), both.get(), copied, should_continue));
    if (copied.stopped) return copied;
  }
  if (lseek(both.get(), 0, SEEK_SET) != 0) return fail(ErrorCode::kUnavailable, "the disk fails");
  return run(
      both.get(), kAlignChildWord, {*std::move(fixed), *std::move(moving)},
      [](int output, Build& build) -> Result<void> {
        std::string text(kLongestAlignment, '\0');
        const ssize_t got = pread(output, text.data(), text.size(), 0);
        if (got < 0) return fail(ErrorCode::kUnavailable, "the disk fails");
        text.resize(static_cast<std::size_t>(got));
        build.aligned = alignment_of(text);
        return {};
      },
      should_continue);
}

Result<Build> SandboxBuilder::run(int input, const char* word, std::vector<std::string> more,
                                  const TakeOutput& take_output,
                                  const ShouldContinue& should_continue) {
  Build build;
  const Fd output(unnamed_file(options_.scratch_dir));
  if (!output) {
    if (errno == ENOSPC || errno == EDQUOT) return no_room();
    return fail(ErrorCode::kUnavailable, "the scratch directory is not writable");
  }

  ChildCommand command;
  command.program = options_.program;
  command.arguments = {word, std::to_string(options_.time_limit_s),
                       std::to_string(options_.memory_limit_mb), std::to_string(options_.quota_mb)};
  std::move(more.begin(), more.end(), std::back_inserter(command.arguments));
  command.input = input;
  command.output = output.get();
  command.time_limit = std::chrono::seconds(options_.time_limit_s);
  const auto began = std::chrono::steady_clock::now();
  auto end = run_child(command, should_continue);
  DIAPHANE_TRY(end);
  build.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  build.peak_bytes = end->peak_bytes;
  const auto verdict = gives_verdict(*end, build);
  DIAPHANE_TRY(verdict);
  if (!*verdict) return build;
  build.verdict = verdict_of(*end);
  if (build.verdict.ready) {
    DIAPHANE_TRY(take_output(output.get(), build));
  }
  return build;
}

namespace {

/// Parses `numbers.size()` arguments, starting at `first`.
bool read_numbers(const std::vector<std::string>& arguments, std::size_t first,
                  std::span<std::uint64_t> numbers) {
  if (arguments.size() < first + numbers.size()) return false;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string& word = arguments[first + i];
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), numbers[i]);
    if (error != std::errc() || stop != word.data() + word.size()) return false;
  }
  return true;
}

/// Parses the limits at the beginning of a child's arguments.
bool read_limits(const std::vector<std::string>& arguments, SandboxLimits& sandbox,
                 std::uint64_t& quota_bytes) {
  std::array<std::uint64_t, 3> numbers{};
  if (!read_numbers(arguments, 0, numbers)) return false;
  sandbox.cpu_seconds = static_cast<std::uint32_t>(numbers[0]);
  sandbox.memory_bytes = numbers[1] * kMb;
  quota_bytes = numbers[2] * kMb;
  sandbox.output_bytes = 2 * quota_bytes + kMb;  // for voxels and the largest labels
  return true;
}

constexpr int kUsage = 64;

}  // namespace

int run_child_with(const std::vector<std::string>& arguments) {
  SandboxLimits sandbox;
  std::uint64_t quota = 0;
  std::array<std::uint64_t, 3> bounds{};
  if (arguments.size() != 6 || !read_limits(arguments, sandbox, quota) ||
      !read_numbers(arguments, 3, bounds)) {
    return kUsage;
  }
  dicom::ScanLimits limits;
  limits.most_voxels = quota / sizeof(std::int16_t);
  return run_child_main(limits, {bounds[0], bounds[1], bounds[2]}, sandbox);
}

int run_label_child_with(const std::vector<std::string>& arguments) {
  SandboxLimits sandbox;
  std::uint64_t quota = 0;
  if (arguments.size() != 4 || !read_limits(arguments, sandbox, quota)) return kUsage;
  return run_label_child_main(arguments[3], sandbox);
}

int run_export_child_with(const std::vector<std::string>& arguments) {
  SandboxLimits sandbox;
  std::uint64_t quota = 0;
  if (arguments.size() != 5 || !read_limits(arguments, sandbox, quota)) return kUsage;
  return run_export_child_main(arguments[3], arguments[4], sandbox);
}

int run_align_child_with(const std::vector<std::string>& arguments) {
  SandboxLimits sandbox;
  std::uint64_t quota = 0;
  if (arguments.size() != 5 || !read_limits(arguments, sandbox, quota)) return kUsage;
  return run_align_child_main(arguments[3], arguments[4], sandbox);
}

int run_cut_child_with(const std::vector<std::string>& arguments) {
  SandboxLimits sandbox;
  std::uint64_t quota = 0;
  if (arguments.size() != 5 || !read_limits(arguments, sandbox, quota)) return kUsage;
  return run_cut_child_main(arguments[3], arguments[4], sandbox);
}

}  // namespace diaphane::ingest
