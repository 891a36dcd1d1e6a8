"""Tables of trials that are broken in one place each, and tables that are unusual but right: name -> bytes.

They are read by `experiment analyse`. A table that is right has one person or too few trials, so that the command
refuses it later, by what it states about its rows.
"""

from __future__ import annotations

HEADER = ("participant,block,trial,haptic,rotation,object,attempt,status,total_time_s,losses_of_contact,"
          "mean_penetration_dm\n")
FIRST = "Ann,1,1,NoH,R,O1,1,done,25.5,21,0.031\n"
SECOND = "Ann,1,2,H,R,O1,1,timeout,,,\n"
TABLE = HEADER + FIRST + SECOND

# What is replaced in the table, and by what: the first place only.
REPLACED = {
    "name_person": ("participant", "person"), "name_block": ("block", "Block"), "name_haptic": ("haptic", "force"),
    "name_rotation": ("rotation", "a4"), "name_object": ("object", "model"), "name_status": ("status", "state"),
    "participant_twice": ("attempt", "participant"), "time_twice": ("losses_of_contact", "total_time_s"),
    "no_participant": ("Ann,1,1,NoH", ",1,1,NoH"), "blank_behind_name": ("Ann,1,2,H", "Ann ,1,2,H"),
    "blank_before_name": ("Ann,1,1", " Ann,1,1"), "escape_in_name": ("Ann,1,1", "A\x1b[2J,1,1"),
    "line_in_name": ("Ann,1,1", '"A\nnn",1,1'), "blank_behind_object": ("R,O1", "R,O1 "),
    "tab_in_object": ("R,O1", "R,O\t1"), "no_object": ("NoH,R,O1", "NoH,R,"),
    "bidirectional_name": ("Ann,1,1", "A\u202ennA,1,1"), "zero_width_name": ("Ann,1,1", "An\u200bn,1,1"),
    "line_separator_name": ("Ann,1,1", "A\u2028nn,1,1"), "soft_hyphen_name": ("Ann,1,1", "A\u00adnn,1,1"),
    "c1_control_name": ("Ann,1,1", "A\u0085nn,1,1"), "delete_in_name": ("Ann,1,1", "A\x7fnn,1,1"),
    "filler_name": ("Ann,1,1", "A\u3164nn,1,1"), "tag_name": ("Ann,1,1", "A\U000e0041nn,1,1"),
    "variation_selector_name": ("Ann,1,1", "A\ufe0fnn,1,1"), "private_use_name": ("Ann,1,1", "A\ue000nn,1,1"),
    "noncharacter_name": ("Ann,1,1", "A\uffffnn,1,1"), "unassigned_name": ("Ann,1,1", "A\U000323b0nn,1,1"),
    "no_break_space_behind_name": ("Ann,1,1", "Ann\u00a0,1,1"), "wide_space_behind_name": ("Ann,1,1", "Ann\u3000,1,1"),
    "mongolian_name": ("Ann,1,1", "A\u180enn,1,1"), "byte_order_mark_in_name": ("Ann,1,1", "A\ufeffnn,1,1"),
    "name_of_100_bytes": ("Ann,1,1", "x" * 100 + ",1,1"), "name_of_101_bytes": ("Ann,1,1", "x" * 101 + ",1,1"),
    "name_of_102_bytes_and_51_letters": ("Ann,1,1", "é" * 51 + ",1,1"),
    "name_of_100_bytes_and_50_letters": ("Ann,1,1", "é" * 50 + ",1,1"),
    "name_of_1000_bytes": ("Ann,1,1", "ab" * 500 + ",1,1"), "name_of_1000_letters": ("Ann,1,1", "日" * 1000 + ",1,1"),
    "name_of_emoji": ("Ann,1,1", "\U0001f600,1,1"), "name_of_joined_emoji": ("Ann,1,1", "👩\u200d🔬,1,1"),
    "name_with_combining_mark": ("Ann,1,1", "Zoe\u0308,1,1"), "name_with_markup": ("Ann,1,1", "<b>&amp;</b>,1,1"),
    "name_of_quotation_marks": ("Ann,1,1", '"""",1,1'), "name_with_quoted_comma": ("Ann,1,1", '"A, B",1,1'),
    "name_na": ("Ann,1,1", "NA,1,1"), "name_nan": ("Ann,1,1", "nan,1,1"), "name_null": ("Ann,1,1", "null,1,1"),
    "block_word": ("Ann,1,1,NoH", "Ann,one,1,NoH"), "block_negative": ("Ann,1,1,NoH", "Ann,-1,1,NoH"),
    "block_fraction": ("Ann,1,1,NoH", "Ann,1.5,1,NoH"), "block_point": ("Ann,1,1,NoH", "Ann,1.0,1,NoH"),
    "block_empty": ("Ann,1,1,NoH", "Ann,,1,NoH"), "block_plus": ("Ann,1,1,NoH", "Ann,+1,1,NoH"),
    "block_zeros": ("Ann,1,1,NoH", "Ann,007,1,NoH"), "block_exponent": ("Ann,1,1,NoH", "Ann,1e2,1,NoH"),
    "block_underscore": ("Ann,1,1,NoH", "Ann,1_0,1,NoH"), "block_arabic": ("Ann,1,1,NoH", "Ann,\u0661,1,NoH"),
    "block_wide": ("Ann,1,1,NoH", "Ann,\uff11,1,NoH"), "block_minus_0": ("Ann,1,1,NoH", "Ann,-0,1,NoH"),
    "block_a_million": ("Ann,1,1,NoH", "Ann,1000000,1,NoH"), "block_too_large": ("Ann,1,1,NoH", "Ann,1000001,1,NoH"),
    "block_beyond_32_bits": ("Ann,1,1,NoH", "Ann,4294967297,1,NoH"),
    "block_beyond_64_bits": ("Ann,1,1,NoH", "Ann,18446744073709551617,1,NoH"),
    "block_na": ("Ann,1,1,NoH", "Ann,NA,1,NoH"), "block_blank": ("Ann,1,1,NoH", "Ann, 1,1,NoH"),
    "trial_0": ("Ann,1,1,NoH", "Ann,1,0,NoH"), "trial_empty": ("Ann,1,1,NoH", "Ann,1,,NoH"),
    "haptic_small": ("NoH", "noh"), "haptic_empty": ("NoH,R", ",R"), "haptic_blank": ("NoH", "NoH "),
    "rotation_a4": ("NoH,R,", "NoH,A4,"), "rotation_na": ("NoH,R,", "NoH,NA,"), "attempt_0": ("1,done", "0,done"),
    "attempt_empty": ("1,done", ",done"), "status_ok": ("done", "ok"), "status_empty": ("timeout", ""),
    "status_large": ("done", "Done"), "time_comma": ("25.5", '"25,5"'), "time_unit": ("25.5", "25.5 s"),
    "time_plus": ("25.5", "+25.5"), "time_negative": ("25.5", "-25.5"), "time_tiny_negative": ("25.5", "-1e-300"),
    "time_minus_0": ("25.5", "-0.0"), "time_minus_inf": ("25.5", "-inf"), "time_nan": ("25.5", "nan"),
    "time_minus_nan": ("25.5", "-nan"), "time_inf": ("25.5", "inf"), "time_infinity": ("25.5", "Infinity"),
    "time_nan_with_payload": ("25.5", "nan(1)"), "time_nan_snan": ("25.5", "nan(snan)"), "time_1e999": ("25.5", "1e999"),
    "time_1e_minus_999": ("25.5", "1e-999"), "time_denormal": ("25.5", "4.9e-324"), "time_0e_minus_999": ("25.5", "0e-999"),
    "time_hexadecimal": ("25.5", "0x1p3"), "time_underscore": ("25.5", "2_5.5"), "time_point_first": ("25.5", ".5"),
    "time_point_last": ("25.5", "5."), "time_point": ("25.5", "."), "time_exponent_alone": ("25.5", "e5"),
    "time_no_exponent": ("25.5", "1e"), "time_exponent_plus": ("25.5", "1e+2"), "time_large_e": ("25.5", "1E2"),
    "time_zeros": ("25.5", "00025.50"), "time_blank": ("25.5", " 25.5"), "time_tab": ("25.5", "25.5\t"),
    "time_arabic": ("25.5", "\u0662\u0665"), "time_minus_sign": ("25.5", "\u22121"), "time_word": ("25.5", "quick"),
    "time_na_small": ("25.5", "na"), "time_n_a": ("25.5", "N/A"), "time_na": ("25.5", "NA"), "time_empty": ("25.5", ""),
    "time_digits": ("25.5", "0." + "3" * 400), "time_many_digits": ("25.5", "1" * 400),
    "time_formula": ("25.5", "=1+1"), "time_currency": ("25.5", "$25"), "time_long_text": ("25.5", "z" * 500),
    "time_text_of_119_bytes_and_a_letter": ("25.5", "z" * 119 + "é"), "time_escape": ("25.5", "\x1b[31m25"),
    "losses_negative": ("21", "-1"), "losses_fraction": ("21", "21.5"), "penetration_negative": ("0.031", "-0.031"),
    "penetration_of_timeout_negative": ("timeout,,,", "timeout,,,-1"), "penetration_nan": ("0.031", "NaN"),
    "time_of_timeout_nan": ("timeout,", "timeout,nan"), "time_of_timeout_inf": ("timeout,", "timeout,inf"),
    "time_of_timeout_word": ("timeout,", "timeout,none"), "field_too_many": ("0.031", "0.031,1"),
    "field_too_few": ("done,25.5,21,0.031", "done,25.5,21"), "field_too_few_in_second": ("timeout,,,", "timeout,,"),
    "trial_twice": ("Ann,1,2,H", "Ann,1,2,NoH"), "mark_without_partner": ("Ann,1,1", '"Ann,1,1'),
    "text_behind_mark": ("Ann,1,1", '"Ann" A,1,1'), "mark_within_field": ("Ann,1,1", 'A"nn,1,1'),
    "carriage_return_within_field": ("Ann,1,1", "A\rnn,1,1"), "mark_at_end": ("0.031", '0.031"'),
    "mark_alone": ("0.031", '"'), "header_in_capitals": ("participant", "PARTICIPANT"),
    "header_with_blank": (",block", ", block"), "header_quoted": ("participant", '"participant"'),
    "header_mark_without_partner": ("participant", '"participant'), "empty_name_of_a_column": ("losses_of_contact", ""),
    "other_column_twice": ("losses_of_contact,mean_penetration_dm", "note,note"),
    "long_name_of_a_column": ("losses_of_contact", "x" * 500), "markup_in_a_column": ("losses_of_contact", "<b>"),
}

LEVELS = "participant,block,haptic,rotation,object,status,view,align,start_orientation_deg,scale\n"
ROW_OF_LEVELS = "1,1,H,R,O1,done,"
LAST_FIELDS = {"as_in_paper": ",NA,,", "other": "still,forward,-144,0.5", "view_wide": "wide,,,",
               "align_backward": ",backward,,", "start_north": ",,north,", "start_nan": ",,nan,",
               "start_too_large": ",,360.1,", "start_at_limit": ",,-360,", "start_inf": ",,inf,", "scale_0": ",,,0",
               "scale_large": ",,,large", "scale_negative": ",,,-1", "scale_inf": ",,,inf", "scale_nan": ",,,nan",
               "scale_tiny": ",,,1e-300", "scale_huge": ",,,1e300", "view_small_na": "na,,,", "view_large": "Still,,,"}
STRATEGY = "participant,block,haptic,rotation,object,status,strategy\n"
STRATEGIES = {"a4": "1,1,,,O1,done,a4\n", "with_haptic": "1,1,H,,O1,done,a4\n", "with_rotation": "1,1,,R,O1,done,a4\n",
              "unknown": "1,1,,,O1,done,magic\n", "na": "1,1,H,R,O1,done,NA\n", "empty": "1,1,H,R,O1,done,\n",
              "empty_and_no_haptic": "1,1,,R,O1,done,\n", "large": "1,1,,,O1,done,A4\n",
              "passive": "1,1,,,O1,done,a4-passive\n", "passive_budget": "1,1,,,O1,done,a4-passive:5\n",
              "passive_zeros": "1,1,,,O1,done,a4-passive:05\n", "anisotropic": "1,1,,,O1,done,anisotropic\n",
              "anisotropic_value": "1,1,,,O1,done,anisotropic:0.25\n",
              "anisotropic_point": "1,1,,,O1,done,anisotropic:.25\n", "blank": "1,1,,,O1,done,a4 \n",
              "twice": "1,1,,,O1,done,a4\n1,1,,,O1,done,a4\n"}
FOLLOWING = "following,participant,block,haptic,rotation,object,status,view\n"
FOLLOWINGS = {"lazy": "lazy,1,1,H,R,O1,done,\n", "na": "NA,1,1,H,R,O1,done,\n", "still": "delayed,1,1,H,R,O1,done,still\n",
              "turning": "adapts-1,1,1,H,R,O1,done,turning\n", "default_view": "adapts-0,1,1,H,R,O1,done,\n",
              "fine": "adapts-0.5,1,1,H,R,O1,done,still\n", "empty": ",1,1,H,R,O1,done,still\n",
              "people_and_simulated": ",1,1,H,R,O1,done,\ndelayed,1,1,H,R,O1,done,\n",
              "view_error_before_time": "delayed,1,1,H,R,O1,done,still\n",
              "status_error_before_view": "delayed,1,1,H,R,O1,ok,still\n",
              "twice": "delayed,1,1,H,R,O1,done,\ndelayed,1,1,H,R,O1,done,turning\n"}


def texts() -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    for name, (before, after) in REPLACED.items():
        assert before in TABLE, name
        found[name] = TABLE.replace(before, after, 1).encode()
    found |= {f"levels_{name}": (LEVELS + ROW_OF_LEVELS + fields + "\n").encode() for name, fields in LAST_FIELDS.items()}
    found |= {f"strategy_{name}": (STRATEGY + rows).encode() for name, rows in STRATEGIES.items()}
    found |= {f"following_{name}": (FOLLOWING + rows).encode() for name, rows in FOLLOWINGS.items()}
    table = TABLE.encode()
    mark = b"\xef\xbb\xbf"
    found |= {
        "empty_file": b"", "header_alone": HEADER.encode(), "header_without_end": HEADER.strip().encode(),
        "mark_of_bytes_alone": mark, "mark_of_bytes": mark + table, "mark_of_bytes_twice": mark + mark + table,
        "zero_byte": table[:100] + b"\0" + table[100:], "zero_byte_first": b"\0" + table,
        "utf_16": TABLE.encode("utf-16"), "semicolons": table.replace(b",", b";"), "tabs": table.replace(b",", b"\t"),
        "latin_1_name": TABLE.replace("Ann", "René", 1).encode("latin-1"),
        "overlong_utf_8": table.replace(b"Ann", b"A\xc0\xafn", 1), "surrogate_utf_8": table.replace(b"Ann", b"A\xed\xa0\x80", 1),
        "cut_utf_8": table.replace(b"Ann", b"An\xe2\x82", 1), "beyond_unicode": table.replace(b"Ann", b"A\xf4\x90\x80\x80", 1),
        "latin_1_other_column": (b"note," + table).replace(b"\nAnn", b"\nR\xe9,Ann"),
        "latin_1_number": table.replace(b"25.5", b"25\xb05", 1), "crlf": table.replace(b"\n", b"\r\n"),
        "cr_alone": table.replace(b"\n", b"\r"), "crlf_and_lf": table.replace(b"\n", b"\r\n", 1),
        "without_end": table.rstrip(b"\n"), "without_end_crlf": table.replace(b"\n", b"\r\n")[:-2],
        "cr_at_end": table + b"\r", "blank_lines": table.replace(b"\n", b"\n\n\n"), "blank_line_first": b"\n" + table,
        "blanks_in_a_line": table + b"  \n", "commas_in_a_line": table + b",,,,,,,,,,\n", "one_more_comma": table[:-1] + b",\n",
        "blank_lines_crlf": table.replace(b"\n", b"\r\n\r\n"), "quoted_empty_line": table + b'""\n',
        "each_field_quoted": b"\n".join(b",".join(b'"' + f + b'"' for f in line.split(b","))
                                        for line in table.strip().split(b"\n")) + b"\n",
        "error_behind_a_name_of_two_lines": b"note," + table.replace(b"\nAnn", b'\n"two\nlines",Ann', 1).replace(
            b"\nAnn,1,2,H", b"\nx,Ann,1,2,h", 1),
        "error_behind_blank_lines": HEADER.encode() + b"\n\n" + FIRST.replace("done", "ok").encode(),
        "mark_open_over_lines": table.replace(b"O1", b'"O1', 1), "attempt_again": (TABLE + FIRST).encode(),
        "attempt_2": (TABLE + FIRST.replace("1,done", "2,done")).encode(),
        "attempt_2_twice": (TABLE + 2 * FIRST.replace("1,done", "2,done")).encode(),
        "trial_twice_with_other_measures": (TABLE + FIRST.replace("25.5", "30")).encode(),
        "trial_twice_with_strategy": (STRATEGY + 2 * "1,2,,,O1,done,cd\n").encode(),
        "trial_twice_with_numbers_in_other_words": (
            LEVELS + "1,1,H,R,O1,done,,,45,0.5\n1,1,H,R,O1,done,turning,nearest,45.0,5e-1\n").encode(),
        "two_errors_in_a_line": TABLE.replace("NoH", "x", 1).replace("done", "y", 1).encode(),
        "errors_in_two_lines": TABLE.replace("timeout", "x").replace("25.5", "y").encode(),
        "measure_error_before_status_error": TABLE.replace("25.5", "y").replace("done", "z").encode(),
        "two_missing_columns": TABLE.replace("haptic", "x").replace("block", "y").encode(),
        "missing_and_repeated_column": TABLE.replace("haptic", "x").replace("trial", "block", 1).encode(),
        "wide_file": ("a," * 3000 + HEADER).encode() + ("1," * 3000 + FIRST).encode(),
        "html": b"<!DOCTYPE html>\n<html><body>Not found</body></html>\n", "json": b'{"participant": 1}\n',
        "gzip": bytes.fromhex("1f8b0800000000000003"), "one_letter": b"x", "one_comma": b",", "one_mark": b'"',
        "one_line_end": b"\n", "columns_of_results": b"name,unit,meaning,paper\nfollowing,,text,\n",
    }
    return found
