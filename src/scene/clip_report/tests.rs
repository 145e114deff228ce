use super::*;

/// Two pairs that touch once and one that touches twice; the last tick is free.
fn report() -> CollisionReport {
    let mut report = CollisionReport::default();
    let ticks: [(u64, &[(&str, &str)]); 6] = [
        (3, &[("satellite", "arm")]),
        (4, &[("arm", "satellite"), ("wall", "satellite")]),
        (5, &[("satellite", "wall")]),
        (6, &[("satellite", "arm"), ("arm", "satellite")]),
        (8, &[("a \"b\",\n\\c", "é")]),
        (9, &[]),
    ];
    for (tick, contacts) in ticks {
        report.record(tick, contacts.iter().copied()).unwrap();
    }
    report
}

fn written(write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> String {
    let mut bytes = Vec::new();
    write(&mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn csv_has_a_row_for_each_pair() {
    assert_eq!(
        written(|bytes| report().write_csv(bytes)),
        "a,b,first_contact,last_contact,ticks,contacts\n\
         arm,satellite,3,6,3,2\n\
         satellite,wall,4,5,2,1\n\
         \"a \"\"b\"\",\n\\c\",é,8,8,1,1\n"
    );
}

#[test]
fn jsonl_has_an_object_for_each_pair() {
    let expected = r#"{"a":"arm","b":"satellite","first_contact":3,"last_contact":6,"ticks":3,"intervals":[[3,4],[6,6]]}
{"a":"satellite","b":"wall","first_contact":4,"last_contact":5,"ticks":2,"intervals":[[4,5]]}
{"a":"a \"b\",\n\\c","b":"é","first_contact":8,"last_contact":8,"ticks":1,"intervals":[[8,8]]}
"#;
    assert_eq!(written(|bytes| report().write_jsonl(bytes)), expected);
}

#[test]
fn ticks_come_one_by_one() {
    assert_eq!(
        written(|bytes| report().write_ticks_csv(bytes)),
        "tick,a,b\n\
         3,arm,satellite\n\
         4,arm,satellite\n\
         4,satellite,wall\n\
         5,satellite,wall\n\
         6,arm,satellite\n\
         8,\"a \"\"b\"\",\n\\c\",é\n"
    );
    assert_eq!(
        written(|bytes| report().write_ticks_jsonl(bytes)),
        r#"{"tick":3,"contacts":[["arm","satellite"]]}
{"tick":4,"contacts":[["arm","satellite"],["satellite","wall"]]}
{"tick":5,"contacts":[["satellite","wall"]]}
{"tick":6,"contacts":[["arm","satellite"]]}
{"tick":8,"contacts":[["a \"b\",\n\\c","é"]]}
"#
    );
}

#[test]
fn an_empty_report_has_columns_only() {
    let report = CollisionReport::default();
    let columns = "a,b,first_contact,last_contact,ticks,contacts\n";
    assert_eq!(written(|bytes| report.write_csv(bytes)), columns);
    assert_eq!(written(|bytes| report.write_ticks_csv(bytes)), "tick,a,b\n");
    assert_eq!(written(|bytes| report.write_jsonl(bytes)), "");
    assert_eq!(report.ticks().count(), 0);
}

#[test]
fn a_tick_left_out_breaks_a_contact() {
    let mut report = CollisionReport::default();
    for tick in [0, 1, 3] {
        report.record(tick, [("a", "b")]).unwrap();
    }
    assert_eq!(report.pairs()[0].intervals, [(0, 1), (3, 3)]);
}

#[test]
fn ticks_out_of_order_are_refused() {
    let mut report = report();
    let before = report.clone();
    for tick in [9, 8] {
        let error = report.record(tick, [("a", "b")]).unwrap_err();
        assert_eq!(error, TickOutOfOrder { tick, previous: 9 });
    }
    assert_eq!(report, before);
}

#[test]
fn the_last_tick_there_is_can_be_recorded() {
    let mut report = CollisionReport::default();
    report.record(u64::MAX - 1, [("a", "b")]).unwrap();
    report.record(u64::MAX, [("a", "b")]).unwrap();
    assert_eq!(report.ticks().count(), 2);
}

#[test]
fn errors_of_the_writer_come_back() {
    let mut full: &mut [u8] = &mut [0; 10];
    assert!(report().write_csv(&mut full).is_err());
    let mut full: &mut [u8] = &mut [0; 10];
    assert!(report().write_ticks_jsonl(&mut full).is_err());
}
