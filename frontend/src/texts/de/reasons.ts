import type { Texts } from "..";
import type { Soon } from "../shape";
import { count, number } from "./counting";

export const reasons: Soon<Texts["add"]["reasons"]> = {
  no_slices: () => "Das sind keine Schichten einer CT-, MRT- oder PET-Aufnahme.",
  screenshots: () => "Das sind Bildschirmfotos, keine Schichten einer Aufnahme.",
  scout: () => "Das ist ein Übersichtsbild, nach dem die Aufnahme geplant wurde.",
  views_not_slices: () => "Das sind Ansichten einer Aufnahme von vielen Seiten, keine Schichten.",
  not_original: () => "Diese Bilder wurden aus einer Aufnahme berechnet; nur ursprüngliche Schichten werden angenommen.",
  no_position: () => "In den Dateien steht nicht, wo im Körper jedes Bild liegt.",
  no_spacing: () => "In den Dateien steht nicht, wie groß die Bilder sind.",
  bad_orientation: () => "In den Dateien steht etwas Unmögliches darüber, wie die Bilder im Körper liegen.",
  one_position: () => "Alle Bilder zeigen dieselbe Stelle zu verschiedenen Zeiten: Es gibt keine Tiefe, die man zeigen könnte.",
  cine: () => "Das ist ein Film von einer Stelle: Es gibt keine Tiefe, die man zeigen könnte.",
  repeated_position: () => "Manche Stellen wurden zweimal aufgenommen, und es ist nicht bekannt, welches Bild gilt.",
  repeated_identifier: () => "Verschiedene Bilder tragen dieselbe Nummer, einige können also fehlen. Bitten Sie das Krankenhaus um eine neue Kopie.",
  time_series: () => "Derselbe Teil des Körpers wurde mehrmals aufgenommen (Kontrastphasen, Echos oder Gewichtungen). Eine solche Serie kann noch nicht gezeigt werden.",
  mixed: () => "Bilder verschiedener Größen oder Richtungen sind hier gemischt, von jeder Art zu wenige.",
  lookup_table: () => "Die Helligkeit dieser Bilder ist auf eine Weise gespeichert, die nicht unterstützt wird.",
  bad_rescale: () => "In den Dateien steht etwas Unmögliches über die Helligkeit der Bilder.",
  no_rescale: () => "In den Dateien steht nicht, was die Helligkeit der Bilder bedeutet.",
  pixel_format: () => "Die Bilder sind in einer Form gespeichert, die nicht unterstützt wird.",
  missing_slices: (n) => `In der Serie ${n === 1 ? "fehlt" : "fehlen"} ${count(n, "Schicht", "Schichten")}; bitte kopieren Sie die CD noch einmal.`,
  varying_spacing: () => "Der Abstand von Schicht zu Schicht schwankt zu sehr für ein Bild, das stimmt.",
  shifted_slices: () => "Einige Schichten sind seitlich gegen die anderen verschoben.",
  tilted: () => "Die Schichten sind zu weit gegeneinander verschoben.",
  unsupported_compression: () => "Die Bilder sind auf eine Weise komprimiert, die nicht unterstützt wird.",
  damaged: () => "Die Dateien enden zu früh: Die CD kann beschädigt sein. Bitte kopieren Sie sie noch einmal.",
  too_few_slices: (n) => `Zu wenige Schichten: ${number.format(n)}, und 16 sind nötig, um Tiefe zu zeigen.`,
  too_short: (n) => `Zu wenige Schichten: Zusammen sind sie ${number.format(n)} mm hoch, und 20 mm sind nötig.`,
  too_large: () => "Diese Serie ist zu groß: Eine Datei darf 1 GB haben, und eine Aufnahme 1024 × 1024 × 1024 Punkte.",
};
