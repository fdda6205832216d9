#include "bench/renderer/multi_process_engine.h"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <thread>

#include "bench/renderer/device_process.h"
#include "common/try.h"

namespace diaphane::render::bench {
namespace {

/// Far more samples than a device ever renders for one picture.
constexpr std::uint64_t kRangeOfADevice = std::uint64_t{1} << 40;

/// Keeps an existing choice of devices in the environment, and selects the k-th of those.
void see_only_device(unsigned k) {
  const char* given = std::getenv("CUDA_VISIBLE_DEVICES");
  std::string name = std::to_string(k);
  if (given != nullptr) {
    std::stringstream list(given);
    for (unsigned i = 0; i <= k && std::getline(list, name, ','); ++i) {
    }
  }
  ::setenv("CUDA_VISIBLE_DEVICES", name.c_str(), 1);
}

struct Worker {
  ProcessWire wire;
  pid_t process;
};

/// The device processes, which end with this object.
class Workers {
 public:
  Workers() = default;
  ~Workers() {
    std::vector<pid_t> processes;
    for (const Worker& worker : workers_) processes.push_back(worker.process);
    workers_.clear();
    for (const pid_t process : processes) ::waitpid(process, nullptr, 0);
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  Result<void> start(EngineChoice choice, unsigned devices, unsigned threads,
                     const volume::Volume& volume) {
    for (unsigned k = 0; k < devices; ++k) {
      int ends[2];
      if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return no_process();
      const pid_t process = ::fork();
      if (process < 0) return no_process();
      if (process == 0) {
        // Closes the sockets of other processes, so that each process notices when its own is
        // closed.
        workers_.clear();
        ::close(ends[0]);
        see_only_device(k);
        serve_device_process(ProcessWire(ends[1]), choice, threads, volume);
        ::_exit(0);
      }
      ::close(ends[1]);
      workers_.push_back({ProcessWire(ends[0]), process});
    }
    return {};
  }

  std::size_t count() const { return workers_.size(); }

  /// Sends all requests at once, each with its own payload, and waits for every answer.
  Result<std::vector<std::string>> ask(ProcessMessageKind word,
                                       const std::vector<std::string>& payloads) {
    for (std::size_t k = 0; k < workers_.size(); ++k) {
      if (!workers_[k].wire.send(word, payloads[k])) return gone();
    }
    std::vector<std::string> answers;
    Result<std::vector<std::string>> trouble;
    for (const Worker& worker : workers_) {
      auto answer = worker.wire.receive();
      if (!answer) return gone();
      if (answer->word == ProcessMessageKind::kFailed) {
        std::string_view rest = answer->payload;
        const auto code = unpacked<ErrorCode>(rest);
        trouble = fail(code, std::string(rest));
      }
      answers.push_back(std::move(answer->payload));
    }
    if (!trouble) return trouble;
    return answers;
  }
  Result<std::vector<std::string>> ask(ProcessMessageKind word, const std::string& payload = {}) {
    return ask(word, std::vector<std::string>(workers_.size(), payload));
  }

 private:
  static tl::unexpected<Error> no_process() {
    return fail(ErrorCode::kInternal, "cannot start a process");
  }
  static tl::unexpected<Error> gone() {
    return fail(ErrorCode::kDeviceLost, "a device's process has ended");
  }
  std::vector<Worker> workers_;
};

class MultiProcessVolume final : public DeviceVolume {
 public:
  explicit MultiProcessVolume(volume::Header header) : header_(std::move(header)) {}
  const volume::Header& header() const override { return header_; }
  std::uint64_t device_bytes() const override { return 0; }

 private:
  volume::Header header_;
};

class MultiProcessRenderer final : public FrameRenderer {
 public:
  explicit MultiProcessRenderer(std::shared_ptr<Workers> workers) : workers_(std::move(workers)) {}

  Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) override {
    auto done =
        workers_->ask(ProcessMessageKind::kScene, packed(canvas) + scene.SerializeAsString());
    DIAPHANE_TRY(done);
    canvas_ = canvas;
    seconds_ = 0;
    return {};
  }

  Result<Batch> render(std::uint32_t samples, const std::function<bool()>&) override {
    const auto begin = std::chrono::steady_clock::now();
    const auto devices = static_cast<std::uint32_t>(workers_->count());
    std::vector<std::string> shares;
    for (std::uint32_t k = 0; k < devices; ++k) {
      shares.push_back(packed(samples / devices + (k < samples % devices ? 1 : 0)));
    }
    auto answers = workers_->ask(ProcessMessageKind::kRender, shares);
    DIAPHANE_TRY(answers);
    Batch batch;
    batch.samples = samples;
    for (std::string_view answer : *answers) {
      batch.dropped_samples += unpacked<Batch>(answer).dropped_samples;
    }
    batch.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    seconds_ += batch.seconds;
    return batch;
  }

  /// Combines independent pictures, whose squared errors add up, weighted by sample count.
  Progress progress() const override {
    Progress progress;
    progress.seconds = seconds_;
    double squared = 0;
    for (const Progress& one : all_progress()) {
      progress.samples += one.samples;
      if (one.samples > 0) squared += std::pow(static_cast<double>(one.samples) * one.error, 2);
    }
    progress.error = std::sqrt(squared) / static_cast<double>(progress.samples);
    return progress;
  }

  Result<void> display(PictureRgb8&) override {
    return fail(ErrorCode::kUnsupported, "a multi-process engine has no display");
  }

  Result<void> radiance(PictureRgbF& out) override {
    const std::vector<Progress> counts = all_progress();
    auto answers = workers_->ask(ProcessMessageKind::kRadiance);
    DIAPHANE_TRY(answers);
    const std::size_t numbers = std::size_t{3} * canvas_.width * canvas_.height;
    std::vector<double> sum(numbers, 0.0);
    double total = 0;
    for (std::size_t k = 0; k < counts.size(); ++k) {
      const auto weight = static_cast<double>(counts[k].samples);
      total += weight;
      std::string_view rest = (*answers)[k];
      for (std::size_t i = 0; weight > 0 && i < numbers; ++i) {
        sum[i] += weight * static_cast<double>(unpacked<float>(rest));
      }
    }
    out.size = canvas_;
    out.pixels.resize(numbers);
    for (std::size_t i = 0; i < numbers; ++i) out.pixels[i] = static_cast<float>(sum[i] / total);
    return {};
  }

  Result<void> contents(std::vector<std::uint8_t>& out) override {
    auto answers = workers_->ask(ProcessMessageKind::kContents);
    DIAPHANE_TRY(answers);
    out.assign(std::size_t{canvas_.width} * canvas_.height, 0);
    for (const std::string& met : *answers) {
      for (std::size_t i = 0; i < out.size(); ++i) out[i] |= static_cast<std::uint8_t>(met[i]);
    }
    return {};
  }

  std::vector<std::string> features() const override {
    std::vector<std::string> names;
    auto answers = workers_->ask(ProcessMessageKind::kFeatures);
    if (!answers) return names;
    std::stringstream lines(answers->front());
    for (std::string line; std::getline(lines, line);) names.push_back(line);
    return names;
  }

 private:
  std::vector<Progress> all_progress() const {
    std::vector<Progress> all;
    auto answers = workers_->ask(ProcessMessageKind::kProgress);
    if (!answers) return all;
    for (std::string_view answer : *answers) all.push_back(unpacked<Progress>(answer));
    return all;
  }

  std::shared_ptr<Workers> workers_;
  Canvas canvas_;
  double seconds_ = 0;
};

class MultiProcessEngine final : public Engine {
 public:
  MultiProcessEngine(EngineChoice choice, unsigned devices, unsigned threads)
      : choice_(choice), devices_(devices), threads_(threads) {}

  EngineInfo info() const override {
    EngineInfo info{choice_ == EngineChoice::kCuda ? "cuda" : "cpu", "", 0};
    if (auto answers = workers_->ask(ProcessMessageKind::kInfo)) {
      info.device = std::to_string(devices_) + " x " +
                    answers->front().substr(answers->front().find('\n') + 1);
    }
    return info;
  }

  Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) override {
    workers_ = std::make_shared<Workers>();
    DIAPHANE_TRY(workers_->start(choice_, devices_, threads_, volume));
    DIAPHANE_TRY(workers_->ask(ProcessMessageKind::kInfo));
    return std::make_shared<MultiProcessVolume>(volume.header);
  }

 private:
  Result<std::unique_ptr<FrameRenderer>> make_renderer(std::shared_ptr<const DeviceVolume>,
                                                       std::uint64_t seed,
                                                       std::uint64_t first_sample,
                                                       Method method) override {
    std::vector<std::string> options;
    for (unsigned k = 0; k < devices_; ++k) {
      options.push_back(packed(RendererOptions{seed, first_sample + k * kRangeOfADevice, method}));
    }
    auto made = workers_->ask(ProcessMessageKind::kRenderer, options);
    DIAPHANE_TRY(made);
    return std::make_unique<MultiProcessRenderer>(workers_);
  }

  EngineChoice choice_;
  unsigned devices_, threads_;
  std::shared_ptr<Workers> workers_ = std::make_shared<Workers>();
};

}  // namespace

Result<std::unique_ptr<Engine>> make_multi_process_engine(EngineChoice choice, unsigned devices,
                                                          unsigned threads) {
  if (choice == EngineChoice::kCpu && threads == 0) {
    threads = std::max(1u, std::thread::hardware_concurrency() / devices);
  }
  return std::make_unique<MultiProcessEngine>(choice, devices, threads);
}

}  // namespace diaphane::render::bench
