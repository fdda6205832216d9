#include "ingest/dicom/series_writer.h"

#include <gdcmFile.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gdcmItem.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmWriter.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "common/ids.h"
#include "common/try.h"

namespace diaphane::dicom {
namespace {

void put(gdcm::DataSet& set, std::uint16_t group, std::uint16_t element, const std::string& vr,
         std::string value) {
  const gdcm::VR type = gdcm::VR::GetVRType(vr.c_str());
  if (value.size() % 2 != 0) {
    const bool zero = vr == "UI" || vr == "OB" || vr == "UN";
    value += zero ? '\0' : ' ';
  }
  gdcm::DataElement item{gdcm::Tag(group, element)};
  item.SetVR(type);
  item.SetByteValue(value.data(), gdcm::VL(static_cast<std::uint32_t>(value.size())));
  set.Replace(item);
}

void put(gdcm::DataSet& set, const ExtraElement& extra) {
  if (extra.vr != "SQ") {
    put(set, extra.group, extra.element, extra.vr, extra.value);
    return;
  }
  gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = new gdcm::SequenceOfItems();
  sequence->SetLengthToUndefined();
  gdcm::Item item;
  item.SetVLToUndefined();
  for (const ExtraElement& inner : extra.items) put(item.GetNestedDataSet(), inner);
  sequence->AddItem(item);
  gdcm::DataElement element{gdcm::Tag(extra.group, extra.element)};
  element.SetVR(gdcm::VR::SQ);
  element.SetValue(*sequence);
  element.SetVLToUndefined();
  set.Replace(element);
}

/// Formats a decimal string, which has at most 16 characters (DICOM PS3.5, 6.2).
std::string ds(double value) {
  char text[40];
  for (int digits = 10; digits > 0; --digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    if (std::string(text).size() <= 16) break;
  }
  return text;
}

template <typename Array>
std::string ds_list(const Array& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : "\\") + ds(value);
  return text;
}

/// Adds an overlay of 8 x 16 bits with a label.
void put_overlay(gdcm::DataSet& set) {
  put(set, 0x6000, 0x0010, "US", us(8));
  put(set, 0x6000, 0x0011, "US", us(16));
  put(set, 0x6000, 0x0040, "CS", "G");
  put(set, 0x6000, 0x0050, "SS", us(1) + us(1));
  put(set, 0x6000, 0x0100, "US", us(1));
  put(set, 0x6000, 0x0102, "US", us(0));
  put(set, 0x6000, 0x1500, "LO", std::string("Label ") + kCanary);
  std::string bits = kCanary;
  bits.resize(16);
  put(set, 0x6000, 0x3000, "OB", bits);
}

void put_patient(gdcm::DataSet& set) {
  const std::string canary = kCanary;
  const auto text = [&](std::uint16_t group, std::uint16_t element, const char* vr,
                        const char* what) {
    put(set, group, element, vr, std::string(what) + canary);
  };
  put(set, 0x0008, 0x0020, "DA", "20180203");
  put(set, 0x0008, 0x0030, "TM", "101112");
  put(set, 0x0010, 0x0010, "PN", kCanaryName);
  text(0x0010, 0x0020, "LO", "ID-0042-");
  put(set, 0x0010, 0x0030, "DA", "19370413");
  put(set, 0x0010, 0x0040, "CS", "O");
  put(set, 0x0010, 0x1010, "AS", "080Y");
  text(0x0010, 0x1000, "LO", "Other-");
  text(0x0010, 0x1040, "LO", "Street 7 ");
  text(0x0010, 0x2154, "SH", "+4930");
  text(0x0010, 0x4000, "LT", "Comment ");
  text(0x0008, 0x0050, "SH", "Acc-");
  text(0x0008, 0x0070, "LO", "Maker ");
  text(0x0008, 0x0080, "LO", "Hospital ");
  text(0x0008, 0x0081, "ST", "Hospital street ");
  text(0x0008, 0x0090, "PN", "Referrer^");
  text(0x0008, 0x1010, "SH", "St");
  text(0x0008, 0x1030, "LO", "Study ");
  text(0x0008, 0x103E, "LO", "Series ");
  text(0x0008, 0x1040, "LO", "Department ");
  text(0x0008, 0x1050, "PN", "Performer^");
  text(0x0008, 0x1070, "PN", "Operator^");
  text(0x0018, 0x1000, "LO", "Serial ");
  text(0x0018, 0x1030, "LO", "Protocol ");
  text(0x0020, 0x0010, "SH", "St");
  text(0x0020, 0x4000, "LT", "Image comment ");
  put(set, {0x0010,
            0x1002,
            "SQ",
            "",
            {{0x0010, 0x0020, "LO", "Nested-" + canary, {}},
             {0x0010, 0x0021, "LO", "Issuer " + canary, {}}}});
  put(set, {0x0040,
            0x0275,
            "SQ",
            "",
            {{0x0040, 0x0007, "LO", "Request " + canary, {}},
             {0x0040, 0x1001, "SH", "Rq" + canary, {}},
             {0x0040, 0x0008, "SQ", "", {{0x0008, 0x0104, "LO", "Deep " + canary, {}}}}}});
  // Private elements, including a sequence and one of unknown representation.
  text(0x0009, 0x0010, "LO", "CREATOR ");
  text(0x0009, 0x1001, "LO", "Private ");
  text(0x0009, 0x1002, "UN", "Unknown ");
  put(set, {0x0009, 0x1003, "SQ", "", {{0x0010, 0x0010, "PN", kCanaryName, {}}}});
  put_overlay(set);
  // Adds trailing data after the pixels.
  text(0xFFFC, 0xFFFC, "OB", "Tail ");
}

void put_image(gdcm::DataSet& set, const SeriesSpec& series, const SliceSpec& slice) {
  put(set, 0x0008, 0x0016, "UI", series.sop_class);
  put(set, 0x0008, 0x0018, "UI", slice.sop_uid.empty() ? new_uid() : slice.sop_uid);
  put(set, 0x0008, 0x0060, "CS", series.modality);
  if (!series.image_type.empty()) put(set, 0x0008, 0x0008, "CS", series.image_type);
  put(set, 0x0018, 0x0050, "DS", ds(series.slice_thickness));
  put(set, 0x0020, 0x000D, "UI", series.study_uid);
  put(set, 0x0020, 0x000E, "UI", series.series_uid);
  put(set, 0x0020, 0x0011, "IS", "1");
  put(set, 0x0020, 0x0013, "IS", std::to_string(slice.instance_number));
  if (series.with_geometry) {
    put(set, 0x0020, 0x0032, "DS", ds_list(slice.position));
    put(set, 0x0020, 0x0037, "DS", ds_list(series.orientation));
    put(set, 0x0020, 0x0052, "UI", series.frame_of_reference_uid);
  }
  put(set, 0x0028, 0x0002, "US", us(series.samples));
  put(set, 0x0028, 0x0004, "CS", series.photometric);
  if (series.samples > 1) put(set, 0x0028, 0x0006, "US", us(0));
  put(set, 0x0028, 0x0010, "US", us(series.rows));
  put(set, 0x0028, 0x0011, "US", us(series.columns));
  put(set, 0x0028, 0x0030, "DS", ds_list(series.pixel_spacing));
  put(set, 0x0028, 0x0100, "US", us(series.bits_allocated));
  put(set, 0x0028, 0x0101, "US", us(series.bits_stored));
  put(set, 0x0028, 0x0102, "US", us(series.high_bit));
  put(set, 0x0028, 0x0103, "US", us(series.is_signed));
  put(set, 0x0028, 0x1050, "DS", ds(series.window_center));
  put(set, 0x0028, 0x1051, "DS", ds(series.window_width));
  if (series.with_rescale) {
    put(set, 0x0028, 0x1052, "DS", ds(series.intercept));
    put(set, 0x0028, 0x1053, "DS", ds(series.slope));
    if (series.modality == "CT") put(set, 0x0028, 0x1054, "LO", "HU");
  }
  put(set, 0x7FE0, 0x0010, series.bits_allocated > 8 ? "OW" : "OB",
      std::string(slice.pixels.begin(), slice.pixels.end()));
}

/// Transcodes with GDCM's own encoder, for compressed syntaxes.
Result<std::string> transcode(const std::string& plain, const std::string& transfer_syntax) {
  std::istringstream in(plain);
  gdcm::ImageReader reader;
  reader.SetStream(in);
  if (!reader.Read()) return fail(ErrorCode::kInvalid, "cannot read the image to compress");
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(
      gdcm::TransferSyntax(gdcm::TransferSyntax::GetTSType(transfer_syntax.c_str())));
  change.SetInput(reader.GetImage());
  if (!change.Change())
    return fail(ErrorCode::kInvalid, "cannot compress the image with this codec");
  gdcm::ImageWriter writer;
  writer.SetFile(reader.GetFile());
  writer.SetImage(change.GetOutput());
  std::ostringstream out;
  writer.SetStream(out);
  if (!writer.Write()) return fail(ErrorCode::kInvalid, "cannot write the compressed image");
  return out.str();
}

}  // namespace

std::string us(std::uint16_t value) {
  return {static_cast<char>(value & 0xff), static_cast<char>(value >> 8)};
}

std::string new_uid() {
  // Converts the random number to decimal by repeated division of its 32 hexadecimal digits.
  const std::string hex = random_hex(16);
  std::vector<int> digits;
  for (const char c : hex) digits.push_back(c <= '9' ? c - '0' : c - 'a' + 10);
  std::string decimal;
  while (std::any_of(digits.begin(), digits.end(), [](int d) { return d != 0; })) {
    int rest = 0;
    for (int& digit : digits) {
      const int value = rest * 16 + digit;
      digit = value / 10;
      rest = value % 10;
    }
    decimal += static_cast<char>('0' + rest);
  }
  if (decimal.empty()) decimal = "0";
  std::reverse(decimal.begin(), decimal.end());
  return "2.25." + decimal;
}

Result<std::string> write_slice(const SeriesSpec& series, const SliceSpec& slice) {
  const gdcm::TransferSyntax syntax(
      gdcm::TransferSyntax::GetTSType(series.transfer_syntax.c_str()));
  const bool encapsulated = syntax.IsEncapsulated();
  gdcm::Writer writer;
  gdcm::File& file = writer.GetFile();
  gdcm::DataSet& set = file.GetDataSet();
  put_image(set, series, slice);
  if (series.with_patient) put_patient(set);
  for (const ExtraElement& extra : series.extra) put(set, extra);
  for (const ExtraElement& extra : slice.extra) put(set, extra);
  file.GetHeader().SetDataSetTransferSyntax(
      encapsulated ? gdcm::TransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian) : syntax);
  std::ostringstream out;
  writer.SetStream(out);
  writer.SetCheckFileMetaInformation(true);
  if (!writer.Write()) return fail(ErrorCode::kInvalid, "cannot write the DICOM file");
  std::string bytes = out.str();
  if (encapsulated) {
    auto compressed = transcode(bytes, series.transfer_syntax);
    if (!compressed) return compressed;
    bytes = std::move(*compressed);
  }
  if (series.with_patient && bytes.size() > 128) {
    const std::string preamble = std::string("Preamble ") + kCanary;
    std::copy(preamble.begin(), preamble.end(), bytes.begin());
  }
  return bytes;
}

Result<void> write_slice_file(const SeriesSpec& series, const SliceSpec& slice,
                              const std::string& path) {
  auto bytes = write_slice(series, slice);
  DIAPHANE_TRY(bytes);
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes->data(), static_cast<std::streamsize>(bytes->size()));
  out.close();
  if (!out) return fail(ErrorCode::kUnavailable, "cannot write a DICOM file");
  return {};
}

}  // namespace diaphane::dicom
