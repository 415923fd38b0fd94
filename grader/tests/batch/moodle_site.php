<?php
/*
 * A Moodle site in small: what its importers do with a filled worksheet and with feedback.zip.
 *
 * Our own, after the rules that grader/batch/MOODLE.md states, with PHP's own strtotime and CSV reader,
 * on which they hang. It reads one JSON object on its standard input and writes one:
 *
 *   site      language, maximum, timezone, team (whether groups hand in), now (seconds since the epoch)
 *   people    by participant: submitted, grade, modified, locked, comment, group (null where there is none)
 *   uploads   in order: {"kind": "worksheet", content (base64, UTF-8), separator, ignore}
 *             or {"kind": "feedback", paths}
 *
 * answer: people, and for each upload what became of each row or path.
 */

const WORDS = [
    'en' => ['id' => 'Identifier', 'grade' => 'Grade', 'date' => 'Last modified (grade)',
             'comment' => 'Feedback comments', 'hidden' => 'Participant '],
    'fr' => ['id' => 'Identifiant', 'grade' => 'Note', 'date' => 'Dernière modification (note)',
             'comment' => 'Feedback par commentaires', 'hidden' => 'Participant'],
];

/* A number as the site's language writes it; what is none stays as it is. */
function number_of(string $text, string $language)
{
    $text = trim(str_replace(["\u{a0}", "\u{202f}", ' '], '', $text));
    if ($text === '') {
        return null;
    }
    return $language === 'fr' ? str_replace(',', '.', $text) : $text;
}

/* The rows of a worksheet, each by its heading; false when a column is missing. */
function rows_of(string $content, array $words, string $separator)
{
    $content = preg_replace('/^\xEF\xBB\xBF/', '', $content);
    $stream = fopen('php://temp', 'w+');
    fwrite($stream, str_replace("\r\n", "\n", $content));
    rewind($stream);
    $header = array_map('trim', fgetcsv($stream, null, $separator, '"', ''));
    $places = array_flip($header);
    foreach (['id', 'grade', 'date'] as $name) {
        if (!isset($places[$words[$name]])) {
            return false;
        }
    }
    $rows = [];
    while (($cells = fgetcsv($stream, null, $separator, '"', '')) !== false) {
        if (count($cells) === count($header)) {
            $rows[] = array_combine($header, $cells);
        }
    }
    return $rows;
}

/* Why a row is passed over; '' when its grade is taken. */
function obstacle(array $person, $grade, bool $stale, array $site): string
{
    $known = array_key_exists('modified', $person) && $person['modified'] !== null;
    if ($known && $person['grade'] !== null && $grade !== null && $person['grade'] == $grade) {
        return 'same';
    }
    if ($grade === null || $grade < 0) {
        return 'empty';
    }
    if ($stale) {
        return 'stale';
    }
    if (!empty($person['locked'])) {
        return 'locked';
    }
    return is_numeric($grade) && $grade <= $site['maximum'] ? '' : 'range';
}

/* A record of a grade: made without one, it is as old as what was handed in. */
function with_record(array $person, int $now): array
{
    if (($person['modified'] ?? null) === null) {
        $person['modified'] = $person['submitted'] ?? $now;
    }
    return $person;
}

function worksheet(array &$people, array $upload, array $site): array
{
    $words = WORDS[$site['language']];
    $rows = rows_of(base64_decode($upload['content']), $words, $upload['separator']);
    if ($rows === false) {
        return ['error' => 'columns'];
    }
    $outcome = [];
    foreach ($rows as $row) {
        $id = substr($row[$words['id']], strlen($words['hidden']));
        if (!isset($people[$id])) {
            continue;
        }
        $person = $people[$id];
        $date = (int) strtotime($row[$words['date']]); /* not understood: the epoch */
        $stale = ($person['modified'] ?? 0) > $date + 60 && empty($upload['ignore']);
        $grade = number_of($row[$words['grade']], $site['language']);
        $why = obstacle($person, $grade, $stale, $site);
        $outcome[$id] = $why === '' ? 'taken' : $why;
        $comment = $row[$words['comment']] ?? '';
        if (!$stale && $comment !== ($person['comment'] ?? '')) {
            $person = with_record($person, $site['now']);
            $person['comment'] = $comment;
        }
        if ($why === '') {
            $person['grade'] = (float) $grade;
            $person['modified'] = $site['now'];
        }
        $people[$id] = $person;
    }
    return $outcome;
}

function feedback(array &$people, array $upload, array $site): array
{
    $outcome = [];
    foreach ($upload['paths'] as $path) {
        $outcome[$path] = [];
        foreach (explode('/', $path) as $part) {
            $words = explode('_', $part, 5);
            if (count($words) < 4 || !is_numeric($words[1]) || $words[2] !== 'assignsubmission') {
                continue;
            }
            foreach ($people as $id => $person) {
                $own = $site['team'] ? ($person['group'] ?? null) : $id;
                if ($own !== null && (int) $own === (int) $words[1]) {
                    $people[$id] = with_record($person, $site['now']);
                    $outcome[$path][] = (string) $id;
                }
            }
            break;
        }
    }
    return $outcome;
}

$asked = json_decode(stream_get_contents(STDIN), true);
$site = $asked['site'];
date_default_timezone_set($site['timezone']);
$people = $asked['people'];
$outcomes = [];
foreach ($asked['uploads'] as $upload) {
    $site['now'] += 60;
    $outcomes[] = $upload['kind'] === 'worksheet'
        ? worksheet($people, $upload, $site) : feedback($people, $upload, $site);
}
echo json_encode(['people' => (object) $people, 'outcomes' => $outcomes], JSON_UNESCAPED_UNICODE);
