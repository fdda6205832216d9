#pragma once

#include <vector>

#include "api/routing/request_router.h"
#include "api/scans/alignments.h"
#include "api/scans/anonymise.h"
#include "api/scans/data_sets.h"
#include "api/scans/scan_exports.h"
#include "api/scans/scan_labels.h"
#include "api/scans/thumbnails.h"
#include "api/scans/uploads.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> data_set_routes(DataSets& data_sets, Thumbnails& thumbnails);
/// Creating an upload with tus announces a data set, like POST /v1/data-sets.
std::vector<Route> upload_routes(Uploads& uploads, DataSets& data_sets);
std::vector<Route> label_routes(ScanLabels& labels);
std::vector<Route> scan_export_routes(ScanExports& exports);
std::vector<Route> alignment_routes(Alignments& alignments);
std::vector<Route> anonymise_routes(Anonymise& anonymise);

}  // namespace diaphane::api
