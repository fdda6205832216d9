// diaphane-operator-bench runs the plan on a simulated fleet, with several policies for placing
// sessions and with lending between devices.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/operator/fleet_model.h"

namespace {

using namespace diaphane::fleet::bench;

constexpr int kExitUsage = 64;
constexpr const char* kUsage =
    R"(usage: diaphane-operator-bench [OPTION VALUE]...

Runs the operator's plan on a simulated fleet, with several policies for placing sessions and with
lending between devices. Prints a table.

  --sessions N       number of sessions (default: 100000)
  --devices N        number of devices (default: 8000)
  --slots N          maximum number of sessions per device (default: 16)
  --seconds N        simulated time in seconds (default: 300)
  --wanted SHARE     share of all devices that the sessions need together (default: 0.7)
  --helpers N        maximum number of devices that a device borrows (default: 7)
  --lend-from SHARE  demand of a device above which it borrows (default: 1.05)
  --merging SHARE    share of a device's time that merging borrowed samples costs (default: 0.125)
  --load-seconds N   time to load a volume on a helper, in seconds (default: 1)
  --seed N           seed of the random numbers (default: 1)
  --json FILE        write the results to this file as JSON
  --csv FILE         write the results to this file as CSV
)";

double percentile(std::vector<double> all, double share) {
  if (all.empty()) return 0;
  std::sort(all.begin(), all.end());
  return all[static_cast<std::size_t>(share * double(all.size() - 1))];
}

bool take(const std::string& name, const char* value, Setting& setting, std::string& json,
          std::string& csv) {
  const double number = std::atof(value);
  if (name == "--sessions") {
    setting.sessions = static_cast<int>(number);
  } else if (name == "--devices") {
    setting.devices = static_cast<int>(number);
  } else if (name == "--slots") {
    setting.slots = static_cast<int>(number);
  } else if (name == "--seconds") {
    setting.seconds = static_cast<int>(number);
  } else if (name == "--wanted") {
    setting.wanted = number;
  } else if (name == "--helpers") {
    setting.lending.most = setting.lending.most_spare = static_cast<std::size_t>(number);
  } else if (name == "--lend-from") {
    setting.lending.borrows = number;
    setting.lending.enough = number - 0.2;
  } else if (name == "--merging") {
    setting.lending_costs.merging = number;
  } else if (name == "--load-seconds") {
    setting.lending_costs.load_seconds = number;
  } else if (name == "--seed") {
    setting.seed = static_cast<std::uint64_t>(number);
  } else if (name == "--json") {
    json = value;
  } else if (name == "--csv") {
    csv = value;
  } else {
    return false;
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  Setting setting;
  setting.lending.most = setting.lending.most_spare = 7;  // as in the chart
  std::string json, csv;
  for (int i = 1; i < argc; i += 2) {
    if (i + 1 < argc && take(argv[i], argv[i + 1], setting, json, csv)) continue;
    const bool help = std::strcmp(argv[i], "--help") == 0;
    std::fputs(kUsage, help ? stdout : stderr);
    return help ? 0 : kExitUsage;
  }
  if (setting.sessions < 1 || setting.devices < 1 || setting.slots < 1 || setting.seconds < 1) {
    std::fprintf(stderr,
                 "diaphane-operator-bench: --sessions, --devices, --slots and --seconds must be at "
                 "least 1\n");
    return kExitUsage;
  }
  std::printf("%d sessions, %d devices, %d slots each, %d s\n", setting.sessions, setting.devices,
              setting.slots, setting.seconds);
  std::printf("%-16s %8s %8s %8s %8s %8s %8s %9s %7s %7s %5s %9s %9s\n", "", "lost", "spread",
              "by node", "busy", "of stays", "by node", "refused", "moves", "drained", "over",
              "plan p50", "plan p99");
  nlohmann::json rows = nlohmann::json::array();
  std::string lines =
      "way,lost,spread,spread_by_node,spread_of_busy,spread_of_stays,spread_of_stays_by_node,lent,"
      "helpers,begun,refused,placings,moves,drained,over,plan_p50_ms,plan_p99_"
      "ms\n";
  for (const Way way : {Way::kLoadAndLending, Way::kLoad, Way::kLeastCount, Way::kRoundRobin}) {
    const Figures figures = FleetModel(setting, way).run();
    const double p50 = 1e3 * percentile(figures.plan_seconds, 0.5);
    const double p99 = 1e3 * percentile(figures.plan_seconds, 0.99);
    std::printf(
        "%-16s %7.3f%% %7.1f%% %7.1f%% %7.1f%% %7.1f%% %7.1f%% %8.4f%% %7ld %7ld %5ld %6.1f ms "
        "%6.1f ms\n",
        name_of(way), 100 * figures.lost, 100 * figures.spread, 100 * figures.spread_by_node,
        100 * figures.spread_of_busy, 100 * figures.spread_of_stays,
        100 * figures.spread_of_stays_by_node, 100 * figures.refused, figures.moves,
        figures.moved_alive, figures.over_committed, p50, p99);
    if (figures.helpers > 0) {
      std::printf(
          "  lent: %.1f%% of the time of all devices, %.2f helpers per device, %.1f requests per "
          "minute\n",
          100 * figures.lent, figures.helpers, figures.begun);
    }
    std::fflush(stdout);
    rows.push_back({{"way", name_of(way)},
                    {"lost", figures.lost},
                    {"spread", figures.spread},
                    {"spread_by_node", figures.spread_by_node},
                    {"spread_of_busy", figures.spread_of_busy},
                    {"spread_of_stays", figures.spread_of_stays},
                    {"spread_of_stays_by_node", figures.spread_of_stays_by_node},
                    {"lent", figures.lent},
                    {"helpers", figures.helpers},
                    {"begun", figures.begun},
                    {"refused", figures.refused},
                    {"placings", figures.placings},
                    {"moves", figures.moves},
                    {"drained", figures.moved_alive},
                    {"over", figures.over_committed},
                    {"plan_p50_ms", p50},
                    {"plan_p99_ms", p99}});
    char line[384];
    std::snprintf(line, sizeof line, "%s,%g,%g,%g,%g,%g,%g,%g,%g,%g,%g,%ld,%ld,%ld,%ld,%g,%g\n",
                  name_of(way), figures.lost, figures.spread, figures.spread_by_node,
                  figures.spread_of_busy, figures.spread_of_stays, figures.spread_of_stays_by_node,
                  figures.lent, figures.helpers, figures.begun, figures.refused, figures.placings,
                  figures.moves, figures.moved_alive, figures.over_committed, p50, p99);
    lines += line;
  }
  const nlohmann::json report{{"sessions", setting.sessions}, {"devices", setting.devices},
                              {"slots", setting.slots},       {"seconds", setting.seconds},
                              {"seed", setting.seed},         {"rows", rows}};
  if (!json.empty()) std::ofstream(json) << report.dump(2) << "\n";
  if (!csv.empty()) std::ofstream(csv) << lines;
  return 0;
}
