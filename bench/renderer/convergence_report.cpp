#include "bench/renderer/convergence_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/renderer/text.h"

namespace diaphane::render::bench {
namespace {

using Json = nlohmann::ordered_json;

const char* points_of(Method method) {
  return method.low_discrepancy ? "low-discrepancy" : "independent";
}
/// Converts to JSON, which has no infinity or NaN.
Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }
Json number(std::optional<double> x) { return x ? number(*x) : Json(nullptr); }

Json json_of(const CurvePoint& p) {
  return {{"samples", p.samples},
          {"milliseconds", p.milliseconds},
          {"milliseconds_spread", p.milliseconds_spread},
          {"rmse", number(p.rmse)},
          {"rmse_spread", number(p.rmse_spread)},
          {"estimate", number(p.estimate)},
          {"ratio", number(p.rmse > 0 ? p.estimate / p.rmse : INFINITY)},
          {"dropped", p.dropped},
          {"non_finite", p.non_finite}};
}

Json json_of(const std::optional<Crossing>& c) {
  if (!c) return nullptr;
  return {{"samples", c->samples}, {"milliseconds", c->milliseconds}, {"how", word_of(c->how)}};
}

Json json_of(const ReportHead& head, const Curve& curve) {
  Json json{{"name", name_of(curve.method)},
            {"walk", word_of(curve.method.walk)},
            {"points", points_of(curve.method)},
            {"mis", word_of(curve.method.mis)},
            {"roulette", curve.method.roulette}};
  if (curve.left_out) {
    json["left_out"] = *curve.left_out;
    return json;
  }
  json["features"] = curve.features;
  json["kernel"] = curve.kernel;
  json["slope"] = number(slope(curve, &CurvePoint::rmse, head.slope_from));
  json["slope_of_estimate"] = number(slope(curve, &CurvePoint::estimate, head.slope_from));
  json["to_target"] = json_of(crossing(curve, head.target));
  json["curve"] = Json::array();
  for (const CurvePoint& point : curve.points) json["curve"].push_back(json_of(point));
  return json;
}

std::uint64_t pixels_of(const Reference& reference) {
  return static_cast<std::uint64_t>(
      std::count(reference.contents.begin(), reference.contents.end(), std::uint8_t{1}));
}

double smallest_rmse(const Convergence& result) {
  double smallest = INFINITY;
  for (const Curve& curve : result.curves) {
    for (const CurvePoint& point : curve.points) {
      if (point.rmse > 0) smallest = std::min(smallest, point.rmse);
    }
  }
  return smallest;
}

}  // namespace

const char* word_of(Walk walk) {
  switch (walk) {
    case Walk::kExact:
      return "exact";
    case Walk::kTracking:
      return "tracking";
    default:
      return "auto";
  }
}

const char* word_of(Crossing::How how) {
  switch (how) {
    case Crossing::How::kFirst:
      return "at the first sample";
    case Crossing::How::kProlonged:
      return "prolonged";
    default:
      return "between";
  }
}

const char* word_of(Mis mis) {
  switch (mis) {
    case Mis::kLight:
      return "light";
    case Mis::kScatter:
      return "scatter";
    default:
      return "both";
  }
}

std::string name_of(Method method) {
  std::string name = method.walk == Walk::kExact      ? "exact walk"
                     : method.walk == Walk::kTracking ? "tracking"
                                                      : "default walk";
  name += method.low_discrepancy ? ", low-discrepancy points" : ", independent points";
  if (method.mis != Mis::kBoth) {
    name += method.mis == Mis::kLight ? ", light samples" : ", scatter samples";
  }
  if (!method.roulette) name += ", no roulette";
  return name;
}

std::string report_json(const ReportHead& head, const Convergence& result) {
  const Reference& r = result.reference;
  Json json{{"bench", "convergence"},
            {"engine", head.engine.engine},
            {"device", head.engine.device},
            {"devices", head.devices},
            {"volume", head.volume},
            {"scene", head.scene},
            {"width", r.canvas.width},
            {"height", r.canvas.height},
            {"repeats", head.repeats},
            {"target", head.target},
            {"slope_from", head.slope_from},
            {"white", r.white},
            {"pixels", pixels_of(r)},
            {"reference",
             {{"samples", r.samples},
              {"error", number(r.error)},
              {"share_of_smallest", number(r.error / smallest_rmse(result))},
              {"seconds", r.seconds}}},
            {"curves", Json::array()}};
  for (const Curve& curve : result.curves) json["curves"].push_back(json_of(head, curve));
  return json.dump(1) + "\n";
}

std::string report_csv(const Convergence& result) {
  std::string text =
      "walk,points,mis,samples,milliseconds,milliseconds_spread,rmse,rmse_spread,estimate,"
      "dropped,non_finite\n";
  for (const Curve& curve : result.curves) {
    for (const CurvePoint& p : curve.points) {
      print(text, "%s,%s,%s,%u,%.6g,%.3g,%.6g,%.3g,%.6g,%llu,%llu\n", word_of(curve.method.walk),
            points_of(curve.method), word_of(curve.method.mis), p.samples, p.milliseconds,
            p.milliseconds_spread, p.rmse, p.rmse_spread, p.estimate,
            static_cast<unsigned long long>(p.dropped),
            static_cast<unsigned long long>(p.non_finite));
    }
  }
  return text;
}

std::string report_text(const ReportHead& head, const Convergence& result) {
  const Reference& r = result.reference;
  std::string text;
  print(text, "%s on %s, %u x %u, %s; %s; %u repetitions\n", head.scene.c_str(),
        head.volume.c_str(), r.canvas.width, r.canvas.height, head.engine.engine.c_str(),
        head.engine.device.c_str(), head.repeats);
  print(text,
        "reference: tracking, independent points, %.0f samples; its own error %.3g (%.2f of the "
        "smallest measured), taken off in quadrature; white %.4g; %llu pixels count (%.0f%%)\n",
        r.samples, r.error, r.error / smallest_rmse(result), r.white,
        static_cast<unsigned long long>(pixels_of(r)),
        100 * static_cast<double>(pixels_of(r)) / static_cast<double>(r.contents.size()));
  for (const Curve& curve : result.curves) {
    print(text, "\n%s\n", name_of(curve.method).c_str());
    if (curve.left_out) {
      print(text, "  left out: %s\n", curve.left_out->c_str());
      continue;
    }
    print(text, "  %8s %12s %9s %10s %10s %7s %8s\n", "samples", "ms", "+-", "true RMSE",
          "estimate", "ratio", "dropped");
    for (const CurvePoint& p : curve.points) {
      print(text, "  %8u %12.4g %9.2g %10.5f %10.5f %7.3f %8llu\n", p.samples, p.milliseconds,
            p.milliseconds_spread, p.rmse, p.estimate, p.estimate / p.rmse,
            static_cast<unsigned long long>(p.dropped + p.non_finite));
    }
    const auto of_truth = slope(curve, &CurvePoint::rmse, head.slope_from);
    const auto of_estimate = slope(curve, &CurvePoint::estimate, head.slope_from);
    if (of_truth && of_estimate) {
      print(text, "  slope from %u samples: %.3f (estimate %.3f)\n", head.slope_from, *of_truth,
            *of_estimate);
    }
    if (const auto c = crossing(curve, head.target)) {
      print(text, "  to RMSE %.3g: %.4g ms, %.3g samples (%s)\n", head.target, c->milliseconds,
            c->samples, word_of(c->how));
    }
  }
  return text;
}

}  // namespace diaphane::render::bench
