import type { Texts } from "../shape";
import { count, number } from "./counting";

export const reasons: Texts["add"]["reasons"] = {
  no_slices: () => "Diese Serie enthält keine CT-, MRT- oder PET-Schichten.",
  screenshots: () => "Das sind Bildschirmfotos, keine Schichten einer Aufnahme.",
  scout: () => "Das ist ein Übersichtsbild, mit dem die Aufnahme geplant wurde.",
  views_not_slices: () => "Diese Bilder zeigen eine Aufnahme von vielen Seiten. Es sind keine Schichten.",
  not_original: () =>
    "Diese Bilder wurden aus einer Aufnahme berechnet. Nur die ursprünglichen Schichten können angezeigt werden.",
  no_position: () => "In den Dateien steht nicht, welches Bild an welche Stelle im Körper gehört.",
  no_spacing: () =>
    "In den Dateien steht nicht, wie groß die Bilder in Millimetern sind, oder die Angabe kann nicht stimmen.",
  bad_orientation: () => "Die Dateien enthalten unmögliche Angaben zur Lage der Bilder im Körper.",
  one_position: () =>
    "Alle Bilder zeigen dieselbe Stelle zu verschiedenen Zeiten. Es gibt also keine Tiefe, die sich zeigen ließe.",
  cine: () => "Das ist ein Video von einer einzigen Stelle im Körper. Es gibt also keine Tiefe, die sich zeigen ließe.",
  repeated_position: () =>
    "Manche Stellen wurden zweimal aufgenommen, und wir wissen nicht, welches Bild das richtige ist.",
  repeated_identifier: () =>
    "Verschiedene Bilder tragen dieselbe Nummer, darum könnten einige fehlen. Bitten Sie das Krankenhaus um eine neue Kopie.",
  incomplete_phases: () =>
    "Derselbe Körperteil wurde mehrmals aufgenommen, aber in den meisten dieser Aufnahmen fehlen Schichten. Versuchen Sie, die Dateien noch einmal von der CD zu kopieren.",
  time_series: () =>
    "Derselbe Körperteil wurde mehrmals aufgenommen (Kontrastphasen, Echos oder Gewichtungen). Solche Serien können noch nicht angezeigt werden.",
  mixed: () => "In dieser Serie sind Bilder verschiedener Arten, Größen oder Richtungen gemischt.",
  lookup_table: () => "Die Helligkeit dieser Bilder ist auf eine Weise gespeichert, die nicht unterstützt wird.",
  bad_rescale: () => "Die Dateien enthalten unmögliche Werte für die Helligkeit der Bilder.",
  no_rescale: () => "In den Dateien steht nicht, was die Helligkeit der Bilder bedeutet.",
  pixel_format: () => "Die Bilder sind in einem Format gespeichert, das nicht unterstützt wird.",
  missing_slices: (n) =>
    `In dieser Serie ${n === 1 ? "fehlt" : "fehlen"} ${count(n, "Schicht", "Schichten")}. Kopieren Sie die Dateien noch einmal von der CD.`,
  varying_spacing: () => "Die Abstände zwischen den Schichten schwanken zu stark für ein genaues Bild.",
  shifted_slices: () => "Einige Schichten sind gegenüber den anderen seitlich verschoben.",
  tilted: () => "Die Schichten sind zu weit gegeneinander verschoben.",
  unsupported_compression: () => "Die Bilder sind auf eine Weise komprimiert, die nicht unterstützt wird.",
  damaged: () =>
    "Die Dateien sind unvollständig, vielleicht ist die CD beschädigt. Kopieren Sie die Dateien noch einmal von der CD.",
  no_voxels: () => "Die Bilddaten liegen in einer zweiten Datei. Wählen Sie beide Dateien zusammen aus.",
  too_few_slices: (n) =>
    `Es ${n === 1 ? "ist nur 1 Schicht" : `sind nur ${number.format(n)} Schichten`} vorhanden. Mindestens 16 sind nötig, um Tiefe zu zeigen.`,
  too_short: (n) => `Die Schichten decken nur ${number.format(n)} mm des Körpers ab. Mindestens 20 mm sind nötig.`,
  too_large: () => "Diese Serie ist zu groß. Erlaubt sind 1 GB pro Datei und 1024 × 1024 × 1024 Punkte pro Aufnahme.",
  over_quota: () =>
    "Für diese Aufnahme reicht Ihr Speicherplatz nicht aus. Löschen Sie andere Aufnahmen und laden Sie diese noch einmal hoch.",
  values_out_of_range: () => "Die Werte dieser Aufnahme sind in einer Form gespeichert, die nicht unterstützt wird.",
  no_memory: () =>
    "Der Server hatte bei jedem Versuch zu wenig Arbeitsspeicher oder Zeit für diese Aufnahme, obwohl sie nicht zu groß ist. Laden Sie die Aufnahme später noch einmal hoch, oder wenden Sie sich an die Administration dieses Servers.",
  upload_gone: () => "Der Upload ist nicht mehr vorhanden. Laden Sie die Aufnahme noch einmal hoch.",
};
