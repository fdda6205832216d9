#include "bench/load/soak_run.h"

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "bench/load/person.h"
#include "bench/load/soak_plan.h"
#include "common/ids.h"

namespace diaphane::api::load {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kPictureWithin = 30;
constexpr double kAskAgain = 1;

// Counts over all users.
struct Tally {
  std::atomic<std::size_t> visits{0}, placings{0}, refused{0}, pictures{0}, no_picture{0};
  std::atomic<std::size_t> drags{0}, hides{0}, resizes{0}, reloads{0}, cuts{0}, ended{0};
  std::atomic<std::size_t> frames{0}, problems{0};
  std::mutex mutex;
  std::map<int, int> closed;
  std::vector<double> opening_seconds;
};

struct Place {
  boost::asio::io_context& io;
  boost::asio::thread_pool& blocking;
  Placement& placement;
  const SoakOptions& options;
  Tally& tally;
  std::atomic<bool>& stopping;
};

// The visits of one user, one after another. Runs on the strand of the current viewer.
class Guest : public std::enable_shared_from_this<Guest> {
 public:
  Guest(Place place, std::uint64_t seed) : place_(place), draws_(seed), user_(new_id()) {}

  void visit() {
    if (place_.stopping) return;
    ++place_.tally.visits;
    visit_ = draw_visit(draws_, place_.options.scale, place_.options.act_seconds);
    session_ = new_id();
    act_ = 0;
    connect();
  }

 private:
  // Requests a ticket and enters with it. Retries until it is admitted, like a page.
  void connect() {
    boost::asio::post(place_.blocking, [self = shared_from_this()] {
      if (self->place_.stopping) return;
      ++self->place_.tally.placings;
      auto placed = self->place_.placement.place(
          {self->session_, self->user_, self->place_.options.data_set});
      if (!placed) {
        ++self->place_.tally.refused;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        return self->connect();
      }
      self->enter(placed->ticket);
    });
  }

  void enter(const std::string& ticket) {
    ViewerOptions options = place_.options.viewer;
    options.width = visit_.width;
    options.height = visit_.height;
    options.read_pause = std::chrono::milliseconds(visit_.read_pause_ms);
    // Uses a local pointer, because after entering, person_ belongs to the strand, where the stream
    // may already have ended.
    const auto person = std::make_shared<Person>(place_.io, options, "");
    person_ = person;
    const auto self = shared_from_this();
    const auto answered = std::make_shared<bool>(false);  // used only on the strand
    person->enter(ticket, [self, answered](bool ready) {
      if (std::exchange(*answered, true)) return;
      if (!ready) return self->come_back(kAskAgain);
      ++self->place_.tally.pictures;
      if (const auto seconds = self->person_->opening_seconds()) {
        const std::lock_guard lock(self->place_.tally.mutex);
        self->place_.tally.opening_seconds.push_back(*seconds);
      }
      self->next_act();
    });
    person->after(kPictureWithin, [self, answered, person] {
      if (std::exchange(*answered, true)) return;
      ++self->place_.tally.no_picture;
      person->cut();
      self->come_back(kAskAgain);
    });
  }

  // Reconnects to the same session after the stream ended.
  void come_back(double seconds) {
    count();
    const auto old = std::exchange(person_, nullptr);
    old->after(seconds, [self = shared_from_this()] { self->connect(); });
  }

  void count() {
    const int code = person_->close_code();
    place_.tally.problems += person_->problems();
    place_.tally.frames += person_->frames();
    if (code < 0) return;
    const std::lock_guard lock(place_.tally.mutex);
    ++place_.tally.closed[code];
  }

  void next_act() {
    if (place_.stopping) return;
    if (person_->close_code() >= 0) return come_back(kAskAgain);
    if (act_ == visit_.acts.size()) return go();
    const Act act = visit_.acts[act_++];
    const auto self = shared_from_this();
    const auto go_on = [self] { self->next_act(); };
    Tally& tally = place_.tally;
    switch (act.kind) {
      case Act::Kind::kLook:
        return person_->after(act.seconds, go_on);
      case Act::Kind::kDrag:
        ++tally.drags;
        return person_->drag(act.seconds, go_on);
      case Act::Kind::kHide:
        ++tally.hides;
        person_->show(false);
        return person_->after(act.seconds, [self] {
          self->person_->show(true);
          self->next_act();
        });
      case Act::Kind::kResize:
        ++tally.resizes;
        std::swap(visit_.width, visit_.height);
        person_->resize(visit_.width, visit_.height);
        return person_->after(act.seconds, go_on);
      case Act::Kind::kReload:
        ++tally.reloads;
        person_->leave();
        return come_back(0.1);
      case Act::Kind::kCut:
        ++tally.cuts;
        person_->cut();
        return come_back(act.seconds);
    }
  }

  void go() {
    person_->leave();
    count();
    const auto self = shared_from_this();
    const bool ends = visit_.ends_session;
    if (ends) ++place_.tally.ended;
    const auto old = std::exchange(person_, nullptr);
    old->after(visit_.pause, [self, ends] {
      boost::asio::post(self->place_.blocking, [self, ends] {
        if (ends) (void)self->place_.placement.end(self->session_);
        self->visit();
      });
    });
  }

  Place place_;
  std::mt19937_64 draws_;
  std::string user_;
  std::string session_;
  Visit visit_;
  std::size_t act_ = 0;
  std::shared_ptr<Person> person_;
};

}  // namespace

Json soak_run(const SoakOptions& options, Placement& placement) {
  Tally tally;
  std::atomic<bool> stopping{false};
  boost::asio::io_context io;
  boost::asio::thread_pool blocking(4);
  auto guard = boost::asio::make_work_guard(io);
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < options.threads; ++i) threads.emplace_back([&] { io.run(); });

  const Place place{io, blocking, placement, options, tally, stopping};
  for (std::size_t i = 0; i < options.people; ++i) {
    std::make_shared<Guest>(place, options.seed * 1'000'003 + i)->visit();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(options.seconds));
  stopping = true;
  blocking.join();
  guard.reset();
  io.stop();
  for (std::thread& thread : threads) thread.join();

  Json closed = Json::object();
  for (const auto& [code, count] : tally.closed) closed[std::to_string(code)] = count;
  return {{"people", options.people},
          {"seconds", options.seconds},
          {"visits", tally.visits.load()},
          {"placings", tally.placings.load()},
          {"refused", tally.refused.load()},
          {"pictures", tally.pictures.load()},
          {"no_picture", tally.no_picture.load()},
          {"drags", tally.drags.load()},
          {"hides", tally.hides.load()},
          {"resizes", tally.resizes.load()},
          {"reloads", tally.reloads.load()},
          {"cuts", tally.cuts.load()},
          {"ended", tally.ended.load()},
          {"frames", tally.frames.load()},
          {"problems", tally.problems.load()},
          {"closed", closed},
          {"opening_ms",
           {{"p50", 1e3 * percentile(tally.opening_seconds, 50)},
            {"p95", 1e3 * percentile(tally.opening_seconds, 95)}}}};
}

}  // namespace diaphane::api::load
