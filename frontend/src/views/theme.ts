import { computed, signal } from "@preact/signals";
import { local } from "../storage";

/** Light or dark: what the device says, until the person says otherwise. */
type Theme = "light" | "dark";

const key = "diaphane.theme";
const device = matchMedia("(prefers-color-scheme: dark)");
const device_dark = signal(device.matches);
device.addEventListener("change", (event) => (device_dark.value = event.matches));

const stored = local.getItem(key);
const chosen = signal<Theme | null>(stored === "light" || stored === "dark" ? stored : null);

export const theme = computed<Theme>(() => chosen.value ?? (device_dark.value ? "dark" : "light"));

export function toggle_theme(): void {
  chosen.value = theme.value === "dark" ? "light" : "dark";
  local.setItem(key, chosen.value);
}

theme.subscribe((value) => {
  document.documentElement.dataset.theme = value;
});
