#include "bench/load/crowd.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "bench/load/hands.h"
#include "common/ids.h"

namespace diaphane::api::load {
namespace {

using Clock = std::chrono::steady_clock;
// Number of concurrent openings, similar to reloads of real pages.
constexpr std::size_t kOpeningAtOnce = 32;

Clock::duration duration_of(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

class Threads {
 public:
  Threads(boost::asio::io_context& io, unsigned count)
      : io_(io), guard_(boost::asio::make_work_guard(io)) {
    for (unsigned i = 0; i < count; ++i) threads_.emplace_back([&] { io_.run(); });
  }
  ~Threads() { stop(); }
  void stop() {
    guard_.reset();
    io_.stop();
    for (std::thread& thread : threads_) {
      if (thread.joinable()) thread.join();
    }
  }

 private:
  boost::asio::io_context& io_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> guard_;
  std::vector<std::thread> threads_;
};

// Counts sessions that are being opened or are ready. Thread-safe, for the strands of the viewers.
class Openings {
 public:
  void wait_below(std::size_t most, Clock::time_point until) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, until, [&] { return begun_ - ended_ < most; });
  }
  void begun() {
    const std::lock_guard lock(mutex_);
    ++begun_;
  }
  void ended(bool ready) {
    const std::lock_guard lock(mutex_);
    ++ended_;
    ready_ += ready;
    changed_.notify_all();
  }
  std::size_t ready() {
    const std::lock_guard lock(mutex_);
    return ready_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t begun_ = 0, ended_ = 0, ready_ = 0;
};

// Starts the next gesture whenever one ends, until it is stopped.
class Conductor : public std::enable_shared_from_this<Conductor> {
 public:
  Conductor(Hands hands, std::vector<std::shared_ptr<Person>> people)
      : hands_(std::move(hands)), people_(std::move(people)) {}

  void begin() {
    const std::lock_guard lock(mutex_);
    for (const Hands::Gesture& gesture : hands_.begin()) start(gesture);
  }
  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }

 private:
  void start(const Hands::Gesture& gesture) {
    people_[gesture.session]->drag(gesture.seconds,
                                   [self = shared_from_this(), session = gesture.session] {
                                     const std::lock_guard lock(self->mutex_);
                                     if (!self->stopped_) self->start(self->hands_.after(session));
                                   });
  }

  std::mutex mutex_;
  Hands hands_;
  std::vector<std::shared_ptr<Person>> people_;
  bool stopped_ = false;
};

void append(std::vector<double>& to, const std::vector<double>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void add(Measurements& all, const Measurements& one) {
  append(all.input_to_frame, one.input_to_frame);
  append(all.answer_seconds, one.answer_seconds);
  append(all.render_seconds, one.render_seconds);
  append(all.encode_seconds, one.encode_seconds);
  all.inputs += one.inputs;
  all.frames += one.frames;
  all.bytes += one.bytes;
  all.moving_frames += one.moving_frames;
  all.moving_bytes += one.moving_bytes;
  all.moving_seconds += one.moving_seconds;
  all.pixels += one.pixels;
}

// The users of one run and their resources.
class Crowd {
 public:
  Crowd(const CrowdOptions& options, Placement& placement)
      : options_(options), placement_(placement), threads_(io_, options.threads) {}

  void open(CrowdResult& result);
  void move_and_measure(const std::function<void(bool)>& measured);
  void end();
  // To be called after end(), because it reads without locks.
  void collect(CrowdResult& result) const;

 private:
  const CrowdOptions& options_;
  Placement& placement_;
  boost::asio::io_context io_;
  Threads threads_;
  Openings openings_;
  std::vector<std::shared_ptr<Person>> people_;
  std::vector<std::string> sessions_;
};

void Crowd::open(CrowdResult& result) {
  const auto until = Clock::now() + duration_of(options_.opening_seconds);
  for (std::size_t i = 0; i < options_.sessions; ++i) {
    openings_.wait_below(kOpeningAtOnce, until);
    // A separate user per session, because a user may have only a few sessions.
    const std::string id = new_id();
    const auto placed = placement_.place({id, new_id(), options_.data_set});
    if (!placed) {
      ++result.refused;
      continue;
    }
    sessions_.push_back(id);
    people_.push_back(std::make_shared<Person>(io_, options_.viewer, options_.preset));
    if (options_.recording) {
      // Each user begins at another place of the recording.
      people_.back()->play(options_.recording, i * options_.recording->size() / options_.sessions);
    }
    openings_.begun();
    people_.back()->enter(placed->ticket, [this](bool ready) { openings_.ended(ready); });
  }
  openings_.wait_below(1, until);
  result.opened = openings_.ready();
}

void Crowd::move_and_measure(const std::function<void(bool)>& measured) {
  // Enough gestures for a long run. A session repeats its gestures from the first after the last.
  const auto trace = render::bench::make_trace("interactive", people_.size(), 120, options_.seed);
  const auto conductor = std::make_shared<Conductor>(Hands(trace, options_.moving), people_);
  conductor->begin();
  std::this_thread::sleep_for(duration_of(options_.warm_up_seconds));
  const TimePoint from = Clock::now();
  const TimePoint until = from + duration_of(options_.seconds);
  for (const auto& person : people_) person->measure(from, until);
  measured(false);
  std::this_thread::sleep_until(until);
  measured(true);
  conductor->stop();
  // Answers to the last requests may still arrive.
  std::this_thread::sleep_for(std::chrono::seconds(2));
}

void Crowd::end() {
  for (const auto& person : people_) person->leave();
  for (const std::string& id : sessions_) (void)placement_.end(id);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  threads_.stop();
}

void Crowd::collect(CrowdResult& result) const {
  const TimePoint now = Clock::now();
  for (const auto& person : people_) {
    person->give_up(now);
    add(result.measurements, person->measurements());
    result.problems += person->problems();
    if (person->close_code() >= 0) ++result.closed[person->close_code()];
    if (const auto opening = person->opening_seconds()) result.opening_seconds.push_back(*opening);
  }
}

}  // namespace

Result<CrowdResult> run_crowd(const CrowdOptions& options, Placement& placement,
                              const std::function<void(bool)>& measured) {
  CrowdResult result;
  Crowd crowd(options, placement);
  crowd.open(result);
  if (result.opened == 0) {
    crowd.end();
    return fail(ErrorCode::kUnavailable,
                "No session shows a picture. See the logs of the programs.");
  }
  crowd.move_and_measure(measured);
  result.seconds = options.seconds;
  crowd.end();
  crowd.collect(result);
  return result;
}

}  // namespace diaphane::api::load
