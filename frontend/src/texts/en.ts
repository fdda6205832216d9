import { account } from "./en/account";
import { admin } from "./en/admin";
import { add } from "./en/add";
import { common } from "./en/common";
import { cut } from "./en/cut";
import { live } from "./en/live";
import { presets } from "./en/presets";
import { my_account } from "./en/my_account";
import { problems } from "./en/problems";
import { recording } from "./en/recording";
import { scans } from "./en/scans";
import { second_factor } from "./en/second_factor";
import { settings } from "./en/settings";
import { sharing } from "./en/sharing";
import { slices } from "./en/slices";
import { take } from "./en/take";
import { titles } from "./en/titles";
import { viewer } from "./en/viewer";

/** Every text of the page, an area a file. Another language is another folder of the same shape. */
export const en = {
  ...common,
  account,
  admin,
  add,
  cut,
  live,
  presets,
  my_account,
  problems,
  recording,
  scans,
  second_factor,
  settings,
  sharing,
  slices,
  take,
  titles,
  viewer,
} as const;
