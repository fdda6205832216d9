#include "renderd/serve/capacity_broker.h"

#include <algorithm>
#include <utility>

#include "common/log.h"

namespace diaphane::render {
namespace {

constexpr std::size_t kAtRandom = 16;
constexpr std::chrono::milliseconds kSample{100};
constexpr std::chrono::seconds kRefusalLasts{30};
/// A device that is busy for this share of the time counts as full.
constexpr double kFull = 0.95;

std::string fleet_of(const std::string& owner) {
  const auto end = owner.find('/');
  return end == std::string::npos ? "" : owner.substr(0, end);
}

bool has_any(const std::vector<std::string>& listed, const std::vector<std::string>& requested) {
  return std::any_of(listed.begin(), listed.end(), [&](const std::string& one) {
    return std::find(requested.begin(), requested.end(), one) != requested.end();
  });
}

}  // namespace

directory::PeerLoad load_of(const directory::Peer& peer, const std::string& node,
                            const std::vector<std::string>& volumes) {
  return {.id = peer.id,
          .load = peer.load,
          .lent = peer.lent,
          .age = peer.age_s,
          .same_node = !peer.node.empty() && peer.node == node,
          .has_volume = has_any(peer.volumes, volumes),
          .draining = peer.draining};
}

CapacityBroker::CapacityBroker(Options options, directory::Client& redis, GrpcAssistants* helpers)
    : options_(std::move(options)),
      helpers_(helpers),
      directory_(redis, options_.worker_id, options_.incarnation),
      since_(Clock::now()) {
  thread_ = std::thread([this] { run(); });
}

CapacityBroker::~CapacityBroker() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
  if (helpers_ != nullptr) helpers_->borrow({});
}

void CapacityBroker::run() {
  std::unique_lock lock(mutex_);
  while (
      !changed_.wait_for(lock, std::min(kSample, options_.period), [this] { return stopping_; })) {
    lock.unlock();
    waited_ += options_.waiting();
    ++ticks_;
    if (Clock::now() - since_ >= options_.period) update();
    lock.lock();
  }
}

CapacityBroker::Use CapacityBroker::use() {
  const auto now = Clock::now();
  Use use;
  use.seconds = std::chrono::duration<double>(now - std::exchange(since_, now)).count();
  const auto part = [&](double until_now, double& before) {
    return std::max(0.0, until_now - std::exchange(before, until_now)) / use.seconds;
  };
  const double busy = std::min(1.0, part(options_.busy_seconds(), busy_before_));
  use.lent = std::min(busy, part(options_.lent_seconds(), lent_before_));
  if (helpers_ != nullptr) use.helped = part(helpers_->helped_seconds(), helped_before_);
  const double waiting = waited_ / static_cast<double>(std::max<std::size_t>(1, ticks_));
  use.waits = waiting > 0;
  waited_ = 0;
  ticks_ = 0;
  // Each waiting session could use the device alone. While the device is not full, sessions get
  // what they ask for.
  use.asked = busy < kFull ? busy - use.lent : std::max(busy - use.lent, waiting);
  return use;
}

bool CapacityBroker::looks_for_helpers(const Use& use) const {
  const directory::LendingRules& rules = options_.rules;
  return helpers_ != nullptr && use.waits &&
         (use.asked >= rules.borrows ||
          (use.asked >= rules.renders && lending_.helpers.size() < rules.most_spare));
}

std::vector<directory::PeerLoad> CapacityBroker::observed_peers(const Use& use) {
  const bool wants = looks_for_helpers(use);
  const bool lends = use.lent > 0;
  addresses_.clear();
  if (!wants && !lends && !lent_reported_ && lending_.helpers.empty()) return {};
  directory::PeerQuery query;
  query.asked = use.asked;
  if (lends) query.lent = use.lent;
  query.fleet = fleet_of(options_.owner);
  query.random = wants ? kAtRandom : 0;
  for (const Helper& helper : lending_.helpers) query.helpers.push_back(helper.id);
  const auto peers = directory_.peers(query);
  // Without an answer, no peer is known to have spare time.
  if (!peers) return {};
  lent_reported_ = lends;
  const std::vector<std::string> ours = options_.volumes();
  std::vector<PeerLoad> found;
  for (const directory::Peer& peer : *peers) {
    if (avoided_.contains(peer.id)) continue;
    found.push_back(load_of(peer, options_.node, ours));
    addresses_[peer.id] = peer.address;
  }
  return found;
}

void CapacityBroker::note_refusals() {
  const auto now = Clock::now();
  std::erase_if(avoided_, [&](const auto& one) { return one.second <= now; });
  for (const std::string& address : helpers_->refusing()) {
    for (const auto& [id, at] : addresses_) {
      if (at == address) avoided_[id] = now + kRefusalLasts;
    }
  }
}

void CapacityBroker::borrow(const Lending& before) {
  const auto helps = [](const Lending& lending, const std::string& id) {
    return std::any_of(lending.helpers.begin(), lending.helpers.end(),
                       [&](const Helper& helper) { return helper.id == id; });
  };
  std::vector<Loan> loans;
  for (const Helper& helper : lending_.helpers) {
    loans.push_back({addresses_.at(helper.id), helper.spare});
    if (!helps(before, helper.id)) {
      log::info("helper_requested", {{"worker", helper.id}, {"spare", helper.spare}});
    }
  }
  for (const Helper& helper : before.helpers) {
    if (!helps(lending_, helper.id)) log::info("helper_released", {{"worker", helper.id}});
  }
  helpers_->borrow(loans);
}

void CapacityBroker::update() {
  if (helpers_ != nullptr) note_refusals();
  const Use now = use();
  const std::vector<PeerLoad> known = observed_peers(now);
  if (helpers_ != nullptr) {
    const Lending before = lending_;
    const double asked = now.waits ? now.asked : 0;
    lending_ = lend(lending_, {now.seconds, asked, now.helped, known}, options_.rules, random_());
    borrow(before);
  }
  if (options_.updated) options_.updated(lending_.helpers.size());
}

}  // namespace diaphane::render
