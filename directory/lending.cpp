#include "directory/lending.h"

#include <algorithm>
#include <random>

namespace diaphane::directory {
namespace {

constexpr double kSameNode = 0.1;

double spare(const PeerLoad& one) { return 1 - one.load - one.lent; }

double worth(const PeerLoad& one) {
  return spare(one) + (one.has_volume ? kLoadedVolumeWorth : 0) + (one.same_node ? kSameNode : 0);
}

bool eligible(const PeerLoad& one, const LendingRules& rules) {
  return !one.draining && one.age <= rules.oldest;
}

}  // namespace

Lending lend(Lending before, const LendingInput& input, const LendingRules& rules,
             std::uint64_t seed) {
  Lending now = std::move(before);
  now.calm = input.asked < rules.enough ? now.calm + input.seconds : 0;
  if (now.calm >= rules.rest) now.helpers.clear();

  std::erase_if(now.helpers, [&](const Helper& helper) {
    const auto known = std::find_if(input.peers.begin(), input.peers.end(),
                                    [&](const PeerLoad& one) { return one.id == helper.id; });
    return known == input.peers.end() || !eligible(*known, rules) || known->load >= rules.busy;
  });
  double lacking = input.asked - 1 - input.helped;
  for (Helper& helper : now.helpers) {
    helper.since += input.seconds;
    if (helper.since < rules.settles) lacking -= helper.expected;
  }
  if (now.helpers.size() > rules.most) now.helpers.resize(rules.most);
  if (input.asked < rules.borrows) return now;

  std::vector<const PeerLoad*> idle;
  for (const PeerLoad& one : input.peers) {
    const bool helps = std::any_of(now.helpers.begin(), now.helpers.end(),
                                   [&](const Helper& helper) { return helper.id == one.id; });
    if (!helps && eligible(one, rules) && one.load + one.lent <= rules.idle) idle.push_back(&one);
  }
  std::minstd_rand random(static_cast<std::minstd_rand::result_type>(seed % 2147483646 + 1));
  while (!idle.empty() && now.helpers.size() < rules.most && lacking > rules.borrows - 1) {
    const auto draw = [&] { return static_cast<std::size_t>(random() % idle.size()); };
    const std::size_t first = draw(), second = draw();
    const std::size_t taken = worth(*idle[first]) >= worth(*idle[second]) ? first : second;
    now.helpers.push_back({idle[taken]->id, spare(*idle[taken]), 0});
    lacking -= spare(*idle[taken]);
    idle.erase(idle.begin() + static_cast<std::ptrdiff_t>(taken));
  }
  return now;
}

}  // namespace diaphane::directory
