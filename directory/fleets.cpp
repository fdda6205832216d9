#include "directory/fleets.h"

#include <algorithm>
#include <charconv>

namespace diaphane::directory {
namespace {

/// Fields of a worker in the reply of fleets.lua.
enum Field { kOwner, kAge, kBusy, kMemory, kSessions, kUsed, kSlots, kError, kDrains, kIdleSince };

double number(std::string_view text) {
  double value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// Returns 0 for text that is not a positive number.
int to_int(std::string_view text) {
  const double value = number(text);
  return value > 0 ? static_cast<int>(std::min(value, 1e9)) : 0;
}

WorkerReport report_of(const Reply& fields, double now) {
  return {.owner = fields.at(kOwner),
          .age_s = number(fields.at(kAge)) / 1000,
          .busy = number(fields.at(kBusy)),
          .memory = number(fields.at(kMemory)),
          .sessions = to_int(fields.at(kSessions)),
          .used = to_int(fields.at(kUsed)),
          .slots = to_int(fields.at(kSlots)),
          .error = number(fields.at(kError)),
          .draining = fields.at(kDrains) == "1",
          .idle_s = (now - number(fields.at(kIdleSince))) / 1000};
}

}  // namespace

Result<FleetPage> read_fleets(Client& client, std::string_view cursor,
                              const std::vector<std::string>& fleets,
                              const std::vector<DrainRequest>& draining) {
  const std::string count = std::to_string(fleets.size());
  Arguments arguments{cursor, count};
  arguments.insert(arguments.end(), fleets.begin(), fleets.end());
  for (const DrainRequest& one : draining)
    arguments.insert(arguments.end(), {one.worker_id, one.owner});
  const Result<Reply> reply = client.run(kFleets, arguments);
  if (!reply) return tl::unexpected(reply.error());
  if (reply->list.size() != 5 || reply->at(0).empty()) {
    return fail(ErrorCode::kInternal, "fleets.lua returned an unexpected reply");
  }
  FleetPage page;
  page.next = reply->at(0);
  const double now = number(reply->at(1));
  for (std::size_t i = 0; i < fleets.size(); ++i) {
    page.demand.push_back({.refused = to_int(reply->list[2].at(i)),
                           .idle_s = (now - number(reply->list[3].at(i))) / 1000});
  }
  for (const Reply& one : reply->list[4].list) page.workers.push_back(report_of(one, now));
  return page;
}

}  // namespace diaphane::directory
