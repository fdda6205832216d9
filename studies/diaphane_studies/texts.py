"""The texts of the tables and figures, in English and German."""

from __future__ import annotations

LANGUAGES = ("en", "de")

_TEXTS: dict[str, tuple[str, str]] = {
    "overview": ("Participants", "Teilnehmende"),
    "count": ("Number", "Anzahl"), "state": ("State", "Stand"), "finished": ("finished", "abgeschlossen"),
    "active": ("not finished", "nicht abgeschlossen"), "withdrawn": ("withdrawn (their answers are deleted)", "widerrufen (Antworten gelöscht)"),
    "level": ("Intervals in brackets have a confidence level of 95%.", "Intervalle in Klammern haben ein Konfidenzniveau von 95 %."),
    "comfort": ("Comfort", "Wohlbefinden"),
    "table1": ("Table 1: chosen minus reference colour", "Tabelle 1: gewählte minus ursprüngliche Farbe"),
    "material": ("Material", "Material"), "measure": ("Measure", "Maß"), "mean": ("Mean", "Mittelwert"), "deviation": ("Standard deviation", "Standardabweichung"),
    "difference": ("Difference", "Differenz"), "weighted": ("Weighted difference", "Gewichtete Differenz"),
    "red": ("red", "Rot"), "green": ("green", "Grün"), "blue": ("blue", "Blau"), "channel": ("Component", "Anteil"),
    "comfort_rule": ("Colours are in steps of sRGB (0 to 255). Weights are the inverse of the rating. A rating of 0 counts as 1. Intervals are of the studentised "
                     "bootstrap over participants.",
                     "Farben in sRGB-Stufen (0 bis 255). Gewichte sind der Kehrwert der Bewertung. Eine Bewertung von 0 zählt als 1. Intervalle nach dem "
                     "studentisierten Bootstrap über Teilnehmende."),
    "no_rating": ("No rating comes before this step, so that all weights are equal.", "Vor diesem Schritt steht keine Bewertung. Deshalb sind alle Gewichte gleich."),
    "effect": ("{name}: the weighted difference is not 0 (Hotelling's T², p {p}, Holm's correction, significance 1%).",
               "{name}: Die gewichtete Differenz ist nicht 0 (Hotellings T², p {p}, Holm-Korrektur, Signifikanz 1 %)."),
    "no_effect": ("{name}: no effect is shown (Hotelling's T², p {p}, Holm's correction, significance 1%).",
                  "{name}: Kein Effekt nachgewiesen (Hotellings T², p {p}, Holm-Korrektur, Signifikanz 1 %)."),
    "figure20": ("Figure 20: reference and more comfortable colours", "Abbildung 20: ursprüngliche und angenehmere Farben"),
    "figure21": ("Figure 21: drawn forms in five settings of comfort", "Abbildung 21: gezeichnete Formen in fünf Stufen des Wohlbefindens"),
    "least_comfortable": ("most uncomfortable", "am unangenehmsten"), "most_comfortable": ("most comfortable", "am angenehmsten"),
    "reference": ("Reference", "Ursprünglich"), "comfortable": ("More comfortable", "Angenehmer"),
    "scale": ("Comfort (times the weighted difference)", "Wohlbefinden (Vielfache der gewichteten Differenz)"),
    "validation": ("Validation of the order", "Prüfung der Reihenfolge"),
    "picture": ("Picture", "Bild"), "expected": ("Expected", "Erwartet"), "agreed": ("Agreed", "Stimmt überein"), "share": ("Share", "Anteil"),
    "below": ("below the reference", "unter dem Original"), "above": ("above the reference", "über dem Original"), "average": ("average", "Durchschnitt"),
    "validation_rule": ("Chance alone gives 50%. Intervals of a picture are Clopper and Pearson's.", "Der Zufall allein ergibt 50 %. Intervalle je Bild nach Clopper und Pearson."),
    "viewpoint": ("Views: {name}", "Ansichten: {name}"), "whole": ("the whole scan", "die ganze Aufnahme"),
    "too_few": ("At least {n} views are needed.", "Mindestens {n} Ansichten sind nötig."),
    "outliers": ("Outliers (average linkage, more than 3 interquartile ranges above the third quartile): {list}.",
                 "Ausreißer (Average Linkage, mehr als 3 Quartilsabstände über dem dritten Quartil): {list}."),
    "no_outliers": ("No view is an outlier.", "Keine Ansicht ist ein Ausreißer."),
    "several": ("{k} canonical views are claimed: the silhouette is greater than that of crowds without clusters (p {p}, significance 1%). Their number has the "
                "greatest silhouette of Gaussian mixtures.",
                "{k} kanonische Ansichten: Die Silhouette ist größer als bei Mengen ohne Gruppen (p {p}, Signifikanz 1 %). Ihre Anzahl hat die größte Silhouette "
                "unter Gaußschen Mischverteilungen."),
    "one": ("Several views are not shown. There is one common view (Rayleigh, p {p}, significance 1%).",
            "Mehrere Ansichten sind nicht nachgewiesen. Es gibt eine gemeinsame Ansicht (Rayleigh, p {p}, Signifikanz 1 %)."),
    "none": ("No claim: the views have no structure that chance would not give (significance 1%).",
             "Keine Aussage: Die Ansichten haben keine Struktur, die nicht auch der Zufall ergäbe (Signifikanz 1 %)."),
    "canonical": ("Canonical views, in the order of the tour", "Kanonische Ansichten in der Reihenfolge der Rundfahrt"),
    "view": ("View", "Ansicht"), "views": ("Views", "Ansichten"), "azimuth": ("Azimuth from the front to the left", "Azimut von vorn nach links"),
    "elevation": ("Elevation", "Höhe"), "distance": ("Distance (radii)", "Abstand (Radien)"), "spread": ("Spread", "Streuung"),
    "figure25": ("Figure 25: dendrogram of the views", "Abbildung 25: Dendrogramm der Ansichten"),
    "figure26": ("Figure 26: tour without and with order", "Abbildung 26: Rundfahrt ohne und mit Ordnung"),
    "figure27": ("Figure 27: canonical views", "Abbildung 27: kanonische Ansichten"),
    "height": ("Distance of the joined groups", "Abstand der verbundenen Gruppen"), "participant": ("Participant", "Teilnehmende Person"),
    "bound": ("Bound of outliers", "Grenze für Ausreißer"), "outlier": ("Outlier", "Ausreißer"), "unordered": ("Unordered", "Ungeordnet"), "ordered": ("Ordered", "Geordnet"),
    "length": ("length {value} radii", "Länge {value} Radien"), "left_axis": ("Left (radii)", "Links (Radien)"), "back_axis": ("Back (radii)", "Hinten (Radien)"),
    "up_axis": ("Up (radii)", "Oben (Radien)"), "region": ("region", "Region"),
    "right": ("right", "rechts"), "front": ("front", "vorn"), "left": ("left", "links"), "back": ("back", "hinten"),
    "latency": ("Latency", "Verzögerung"), "delay": ("Delay (ms)", "Verzögerung (ms)"), "accepted": ("Accepted", "Akzeptiert"), "rating": ("Rating", "Bewertung"),
    "seconds": ("Time for the task (s)", "Zeit für die Aufgabe (s)"), "error": ("Error (°)", "Fehler (°)"), "threshold": ("Threshold", "Schwelle"),
    "accepts": ("accepted by {share}", "von {share} akzeptiert"), "beyond": ("above {value} ms", "über {value} ms"),
    "by_delay": ("Acceptance, rating and task by delay", "Akzeptanz, Bewertung und Aufgabe nach Verzögerung"),
    "thresholds": ("Delays that participants accept", "Akzeptierte Verzögerungen"),
    "latency_rule": ("A cumulative Gaussian with lapses is fitted by maximum likelihood. Intervals resample participants. Times are geometric means.",
                     "Eine kumulative Normalverteilung mit Fehlgriffen ist nach maximaler Likelihood angepasst. Intervalle ziehen Teilnehmende neu. "
                     "Zeiten sind geometrische Mittel."),
    "no_threshold": ("No threshold is claimed: acceptance does not depend on the delay (p {p}, significance 1%).",
                     "Keine Aussage über eine Schwelle: Die Akzeptanz hängt nicht von der Verzögerung ab (p {p}, Signifikanz 1 %)."),
    "rising": ("No threshold is claimed: acceptance does not fall with the delay.", "Keine Aussage über eine Schwelle: Die Akzeptanz fällt nicht mit der Verzögerung."),
    "sus": ("System Usability Scale", "System Usability Scale"), "score": ("Score (0 to 100)", "Punktzahl (0 bis 100)"),
    "questions": ("Ratings", "Bewertungen"), "question": ("Question", "Frage"), "range": ("Range", "Bereich"), "choice": ("Choices", "Auswahl"),
    "option": ("Option", "Möglichkeit"), "words": ("Words", "Freie Antworten"), "answer": ("Answer", "Antwort"), "n": ("n", "n"), "interval": ("Interval", "Intervall"),
    "statement": ("Statement {n}", "Aussage {n}"),
}


class Texts:
    """The texts in one language, and numbers as this language writes them."""

    def __init__(self, language: str) -> None:
        self.language = language if language in LANGUAGES else "en"

    def __call__(self, key: str, **values: object) -> str:
        return _TEXTS[key][LANGUAGES.index(self.language)].format(**values)

    def number(self, value: float, digits: int = 0) -> str:
        if value != value:      # NaN: there are too few answers
            return "–"
        written = f"{value:.{digits}f}"
        if float(written) == 0:
            written = written.removeprefix("-")
        return (written.replace(".", ",") if self.language == "de" else written).replace("-", "−")

    def percent(self, share: float) -> str:
        return "–" if share != share else self.number(100 * share) + ("%" if self.language == "en" else " %")

    def p_value(self, value: float) -> str:
        return "< " + self.number(0.001, 3) if value < 0.001 else "= " + self.number(value, 3)

    def interval(self, low: float, high: float, digits: int = 0) -> str:
        return "–" if low != low else f"[{self.number(low, digits)}; {self.number(high, digits)}]"

    def share_interval(self, low: float, high: float) -> str:
        return "–" if low != low else f"[{self.percent(low)}; {self.percent(high)}]"
