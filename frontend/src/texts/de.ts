import type { Texts } from "./shape";
import { account } from "./de/account";
import { add } from "./de/add";
import { archive } from "./de/archive";
import { apiTokens } from "./de/api_tokens";
import { admin } from "./de/admin";
import { common } from "./de/common";
import { compare } from "./de/compare";
import { consent } from "./de/consent";
import { cut } from "./de/cut";
import { home } from "./de/home";
import { curve } from "./de/curve";
import { kernel } from "./de/kernel";
import { labels } from "./de/labels";
import { legal } from "./de/legal";
import { live } from "./de/live";
import { myAccount } from "./de/my_account";
import { marks } from "./de/marks";
import { phases } from "./de/phases";
import { presets } from "./de/presets";
import { problems } from "./de/problems";
import { recording } from "./de/recording";
import { scanFile } from "./de/scan_file";
import { scans } from "./de/scans";
import { secondFactor } from "./de/second_factor";
import { settings } from "./de/settings";
import { sharing } from "./de/sharing";
import { slices } from "./de/slices";
import { studies } from "./de/studies";
import { take } from "./de/take";
import { takePart } from "./de/take_part";
import { titles } from "./de/titles";
import { viewer } from "./de/viewer";

/** All texts in German. */
export const de: Texts = {
  ...common,
  account,
  add,
  apiTokens,
  archive,
  admin,
  compare,
  consent,
  cut,
  home,
  curve,
  kernel,
  labels,
  legal,
  live,
  marks,
  myAccount,
  phases,
  presets,
  problems,
  recording,
  scanFile,
  scans,
  secondFactor,
  settings,
  sharing,
  slices,
  studies,
  take,
  takePart,
  titles,
  viewer,
};
