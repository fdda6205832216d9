#include "ingest/pipeline/builder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <iterator>
#include <new>

#include "common/fd.h"
#include "ingest/pipeline/child.h"
#include "ingest/pipeline/cut_child.h"
#include "ingest/pipeline/supervisor.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

constexpr std::uint64_t kMb = std::uint64_t{1} << 20;

/// A file without a name, so that nothing is left of it however we end.
int unnamed_file(const std::string& directory) {
  const int fd = open(directory.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (fd >= 0) return fd;
  std::string name = directory + "/voxels-XXXXXX";  // a file system that has no such thing
  const int named = mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) unlink(name.c_str());
  return named;
}

/// The child has left the descriptor at the end.
bool read_from_start(int fd, char* data, std::size_t bytes) {
  off_t at = 0;
  while (bytes > 0) {
    const ssize_t got = pread(fd, data, bytes, at);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    data += got;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

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
      return refused("too_slow", "This upload took too long to read.");
    case ChildEnd::How::kCrashed:
    case ChildEnd::How::kStopped:
      break;
  }
  return unsafe();
}

/// The voxels that the child left. The header's numbers are the child's, which may lie: size and
/// range of what is really there are checked and measured here.
Result<void> take_voxels(int fd, std::uint64_t most_voxels, Build& build) {
  build.volume.header = std::move(build.verdict.header);
  const std::uint64_t count = build.volume.header.voxel_count();
  struct stat info {};
  if (fstat(fd, &info) != 0) return fail(ErrorCode::kInternal, "the voxels cannot be read back");
  if (count > most_voxels ||
      static_cast<std::uint64_t>(info.st_size) != count * sizeof(std::int16_t)) {
    build.verdict = unsafe();
    return {};
  }
  try {
    build.volume.voxels.resize(count);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "no memory for the volume");
  }
  if (!read_from_start(fd, reinterpret_cast<char*>(build.volume.voxels.data()),
                       count * sizeof(std::int16_t))) {
    return fail(ErrorCode::kInternal, "the voxels cannot be read back");
  }
  volume::measure(build.volume, build.verdict.filler);
  return {};
}

}  // namespace

Result<Build> SandboxBuilder::build(const std::string& upload_path, const GoOn& go_on) {
  const Fd input(open(upload_path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!input) {
    if (errno != ENOENT) return fail(ErrorCode::kUnavailable, "the upload cannot be opened");
    Build build;
    build.verdict = refused("upload_gone", "The upload is gone; please send it again.");
    return build;
  }
  return run(input.get(), kChildWord, {}, go_on);
}

Result<Build> SandboxBuilder::cut(const CutInput& wanted, const GoOn& go_on) {
  auto header = volume::to_json(wanted.header);
  if (!header) return tl::unexpected(header.error());
  const std::string voxels = wanted.volume_directory + "/voxels.i16";
  const Fd input(open(voxels.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!input) return fail(ErrorCode::kUnavailable, "the stored voxels cannot be opened");
  return run(input.get(), kCutChildWord, {*std::move(header), volume::to_json(wanted.region)},
             go_on);
}

Result<Build> SandboxBuilder::run(int input, const char* word, std::vector<std::string> more,
                                  const GoOn& go_on) {
  Build build;
  const Fd output(unnamed_file(options_.scratch_dir));
  if (!output) return fail(ErrorCode::kUnavailable, "the scratch directory cannot be written");

  ChildCommand command;
  command.program = options_.program;
  command.arguments = {word, std::to_string(options_.time_limit_s),
                       std::to_string(options_.memory_limit_mb), std::to_string(options_.quota_mb)};
  std::move(more.begin(), more.end(), std::back_inserter(command.arguments));
  command.input = input;
  command.output = output.get();
  command.time_limit = std::chrono::seconds(options_.time_limit_s);
  const auto began = std::chrono::steady_clock::now();
  auto end = run_child(command, go_on);
  if (!end) return tl::unexpected(end.error());
  build.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  build.peak_bytes = end->peak_bytes;
  if (end->how == ChildEnd::How::kStopped) {
    build.stopped = true;
    return build;
  }
  // It never came to reading: no sandbox on this machine, too little memory to start in. Our fault.
  constexpr int kNoSandbox = 70, kNoProgram = 127;
  if (end->how == ChildEnd::How::kExited &&
      (end->exit_code == kNoSandbox || end->exit_code == kNoProgram)) {
    return fail(ErrorCode::kInternal, "the child cannot start");
  }
  build.verdict = verdict_of(*end);
  if (build.verdict.ready) {
    if (auto ok = take_voxels(output.get(), options_.quota_mb * kMb / 2, build); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  return build;
}

namespace {

/// The limits that come first among a child's arguments.
bool read_limits(const std::vector<std::string>& arguments, SandboxLimits& sandbox,
                 std::uint64_t& quota_bytes) {
  std::uint64_t numbers[3]{};
  if (arguments.size() < 3) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string& word = arguments[i];
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), numbers[i]);
    if (error != std::errc() || stop != word.data() + word.size()) return false;
  }
  sandbox.cpu_seconds = static_cast<std::uint32_t>(numbers[0]);
  sandbox.memory_bytes = numbers[1] * kMb;
  sandbox.output_bytes = quota_bytes = numbers[2] * kMb;
  return true;
}

constexpr int kUsage = 64;

}  // namespace

int run_child_with(const std::vector<std::string>& arguments) {
  SandboxLimits sandbox;
  std::uint64_t quota = 0;
  if (arguments.size() != 3 || !read_limits(arguments, sandbox, quota)) return kUsage;
  dicom::ScanLimits limits;
  limits.most_voxels = quota / sizeof(std::int16_t);
  return run_child_main(limits, sandbox);
}

int run_cut_child_with(const std::vector<std::string>& arguments) {
  SandboxLimits sandbox;
  std::uint64_t quota = 0;
  if (arguments.size() != 5 || !read_limits(arguments, sandbox, quota)) return kUsage;
  return run_cut_child_main(arguments[3], arguments[4], sandbox);
}

}  // namespace diaphane::ingest
