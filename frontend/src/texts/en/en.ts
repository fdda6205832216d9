import { account } from "./account";
import { admin } from "./admin";
import { add } from "./add";
import { archive } from "./archive";
import { apiTokens } from "./api_tokens";
import { common } from "./common";
import { compare } from "./compare";
import { consent } from "./consent";
import { cut } from "./cut";
import { home } from "./home";
import { curve } from "./curve";
import { kernel } from "./kernel";
import { labels } from "./labels";
import { legal } from "./legal";
import { live } from "./live";
import { marks } from "./marks";
import { phases } from "./phases";
import { presets } from "./presets";
import { myAccount } from "./my_account";
import { problems } from "./problems";
import { recording } from "./recording";
import { scanFile } from "./scan_file";
import { scans } from "./scans";
import { secondFactor } from "./second_factor";
import { settings } from "./settings";
import { sharing } from "./sharing";
import { slices } from "./slices";
import { studies } from "./studies";
import { take } from "./take";
import { takePart } from "./take_part";
import { titles } from "./titles";
import { viewer } from "./viewer";

/** All texts of the page, one file per area. Each language has a folder of the same structure. */
export const en = {
  ...common,
  account,
  admin,
  add,
  apiTokens,
  archive,
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
  phases,
  presets,
  myAccount,
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
} as const;
