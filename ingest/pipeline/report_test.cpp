#include "ingest/pipeline/report.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/sandbox/supervisor.h"

namespace diaphane::ingest {
namespace {

TEST(Report, RoundTrips) {
  Verdict verdict = refused("too_few_slices", "Too few slices: 3.");
  auto again = read_report(write_report(verdict));
  ASSERT_TRUE(again.has_value());
  EXPECT_FALSE(again->ready);
  EXPECT_EQ(again->code, verdict.code);
  EXPECT_EQ(again->text, verdict.text);
  verdict = {};
  verdict.ready = true;
  verdict.header.size = {4, 3, 2};
  verdict.header.repairs = {"one slice was there twice"};
  again = read_report(write_report(verdict));
  ASSERT_TRUE(again.has_value());
  EXPECT_TRUE(again->ready);
  EXPECT_EQ(again->header.size, verdict.header.size);
  EXPECT_EQ(again->header.repairs, verdict.header.repairs);
}

TEST(Report, CarriesThePlaceOfAScanUnlessItIsInvalid) {
  Verdict verdict;
  verdict.ready = true;
  verdict.header.size = {4, 3, 2};
  verdict.header.frame_of_reference = "1.2.3";
  verdict.header.origin = {1, 2, 3};
  auto again = read_report(write_report(verdict));
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->header.frame_of_reference, "1.2.3");
  EXPECT_EQ(again->header.origin, verdict.header.origin);
  verdict.header.frame_of_reference = "M\xfcller";
  verdict.header.origin = {1, std::nan(""), 3};
  again = read_report(write_report(verdict));
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->header.frame_of_reference, "");
  EXPECT_FALSE(again->header.origin);
  std::string lying = write_report(verdict);
  lying.replace(lying.find("\"frame\":\"\""), 10, "\"frame\":\"x\"");
  EXPECT_FALSE(read_report(lying).has_value());
}

TEST(Report, RefusesReportsOfACompromisedChild) {
  EXPECT_FALSE(read_report(std::string(kLongestReport + 1, 'x')).has_value()) << "endless";
  for (const std::string bad :
       {std::string(), std::string("{"), std::string("[]"), std::string("{\"code\":\"x\"}"),
        std::string(R"({"code":"Robert'); DROP TABLE","text":"x"})"),
        std::string(R"({"code":"x","text":"M\u00fcller"})"),
        std::string(R"({"code":"x","text":"a\nb"})"), std::string(R"({"code":1,"text":2})"),
        std::string(R"({"header":"{}"})"), std::string(R"({"header":{"size":[1,1,1]}})"),
        R"({"code":"x","text":)" + std::string(250'000, '[') + std::string(250'000, ']') + "}",
        R"({"code":"x","text":")" + std::string(5000, 'y') + "\"}"}) {
    EXPECT_FALSE(read_report(bad).has_value()) << bad.substr(0, 200);
  }
  Verdict verdict;
  verdict.ready = true;
  verdict.header.size = {4, 3, 2};
  verdict.header.repairs.assign(50, "x");
  EXPECT_FALSE(read_report(write_report(verdict)).has_value()) << "a flood of repairs";
  verdict.header.repairs = {"M\xc3\xbcller"};
  EXPECT_FALSE(read_report(write_report(verdict)).has_value()) << "no text of ours";
  verdict.header.repairs = {};
  verdict.header.content_hash = "blake2b:00";
  EXPECT_FALSE(read_report(write_report(verdict)).has_value()) << "the hash is the parent's to say";
}

}  // namespace
}  // namespace diaphane::ingest
