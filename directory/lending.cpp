#include "directory/lending.h"

#include <algorithm>
#include <random>
#include <utility>

namespace diaphane::directory {
namespace {

constexpr double kSameNode = 0.1;

double spare(const PeerLoad& one) { return 1 - one.load - one.lent; }

double worth(const PeerLoad& one) {
  return spare(one) + (one.has_volume ? kLoadedVolumeWorth : 0) + (one.same_node ? kSameNode : 0);
}

const PeerLoad* find(const std::vector<PeerLoad>& peers, const std::string& id) {
  const auto known =
      std::find_if(peers.begin(), peers.end(), [&](const PeerLoad& one) { return one.id == id; });
  return known == peers.end() ? nullptr : &*known;
}

bool eligible(const PeerLoad& one, const LendingRules& rules) {
  return !one.draining && one.age <= rules.oldest;
}

bool may_stay(const Helper& helper, const PeerLoad* peer, const LendingRules& rules) {
  return peer != nullptr && eligible(*peer, rules) &&
         peer->load < (helper.spare ? rules.spare_busy : rules.busy);
}

void count_seconds(Lending& now, const LendingInput& input, const LendingRules& rules) {
  // One session alone asks for the whole device. It gets spare time, and needs nothing.
  const bool calm = rules.most_spare > 0 ? input.asked <= 1 : input.asked < rules.enough;
  now.calm = calm ? now.calm + input.seconds : 0;
  now.still = input.asked < rules.renders ? now.still + input.seconds : 0;
  for (Helper& helper : now.helpers) helper.since += input.seconds;
}

/// Releases helpers, or keeps them with spare time.
void release(Lending& now, const LendingInput& input, const LendingRules& rules) {
  if (now.calm >= rules.rest) {
    for (Helper& helper : now.helpers) helper.spare = true;
  }
  std::erase_if(now.helpers, [&](const Helper& helper) {
    return (helper.spare && now.still >= rules.lingers) ||
           !may_stay(helper, find(input.peers, helper.id), rules);
  });
  const std::size_t most = now.calm >= rules.rest ? rules.most_spare : rules.most;
  if (now.helpers.size() > most) now.helpers.resize(most);
}

/// The peers from which helpers are drawn.
class Draw {
 public:
  Draw(const std::vector<PeerLoad>& peers, const std::vector<Helper>& helpers,
       const LendingRules& rules, double idle, std::uint64_t seed)
      : random_(static_cast<std::minstd_rand::result_type>(seed % 2147483646 + 1)) {
    for (const PeerLoad& one : peers) {
      const bool helps = std::any_of(helpers.begin(), helpers.end(),
                                     [&](const Helper& helper) { return helper.id == one.id; });
      if (!helps && eligible(one, rules) && one.load + one.lent <= idle) idle_.push_back(&one);
    }
  }
  /// Returns the better of two random peers, and removes it, or returns null.
  const PeerLoad* next() {
    if (idle_.empty()) return nullptr;
    const auto draw = [&] { return static_cast<std::size_t>(random_() % idle_.size()); };
    const std::size_t first = draw(), second = draw();
    const std::size_t taken = worth(*idle_[first]) >= worth(*idle_[second]) ? first : second;
    const PeerLoad* one = idle_[taken];
    idle_.erase(idle_.begin() + static_cast<std::ptrdiff_t>(taken));
    return one;
  }

 private:
  std::minstd_rand random_;
  std::vector<const PeerLoad*> idle_;
};

/// Adds helpers while capacity is lacking. They replace helpers that have only spare time.
void borrow_more(Lending& now, double lacking, const LendingInput& input, const LendingRules& rules,
                 std::uint64_t seed) {
  Draw draw(input.peers, now.helpers, rules, rules.idle, seed);
  while (lacking > rules.borrows - 1) {
    const auto only_spare = std::find_if(now.helpers.begin(), now.helpers.end(),
                                         [](const Helper& helper) { return helper.spare; });
    const bool full = now.helpers.size() >= rules.most;
    if (full && only_spare == now.helpers.end()) return;
    const PeerLoad* one = draw.next();
    if (one == nullptr) return;
    if (full) now.helpers.erase(only_spare);
    now.helpers.push_back({one->id, spare(*one), 0});
    lacking -= spare(*one);
  }
}

}  // namespace

Lending lend(Lending before, const LendingInput& input, const LendingRules& rules,
             std::uint64_t seed) {
  Lending now = std::move(before);
  count_seconds(now, input, rules);
  release(now, input, rules);
  if (input.asked >= rules.borrows) {
    double lacking = input.asked - 1 - input.helped;
    for (const Helper& helper : now.helpers) {
      if (!helper.spare && helper.since < rules.settles) lacking -= helper.expected;
    }
    for (Helper& helper : now.helpers) {
      const PeerLoad& peer = *find(input.peers, helper.id);
      if (!helper.spare || lacking <= rules.borrows - 1 || peer.load + peer.lent > rules.idle) {
        continue;
      }
      // It has loaded the volume, if it was asked more than a moment ago.
      helper.spare = false;
      helper.expected = spare(peer);
      lacking -= helper.expected;
    }
    borrow_more(now, lacking, input, rules, seed);
    return now;
  }
  if (input.asked < rules.renders) return now;
  Draw draw(input.peers, now.helpers, rules, rules.spare_idle, seed);
  while (now.helpers.size() < rules.most_spare) {
    const PeerLoad* one = draw.next();
    if (one == nullptr) break;
    now.helpers.push_back({one->id, spare(*one), 0, true});
  }
  return now;
}

}  // namespace diaphane::directory
